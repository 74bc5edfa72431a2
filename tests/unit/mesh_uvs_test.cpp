// SPDX-License-Identifier: Apache-2.0
// Texture coordinates from files through repair to the corners of the mesh.
#include "common/geometry/mesh_uvs.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <numeric>

#include "common/base/errors.h"
#include "common/geometry/surface.h"
#include "tests/support/error_text.h"
#include "tests/support/mesh_soups.h"
#include "tests/support/test_files.h"

namespace tallow {
namespace {

using Uvs = std::vector<Vec2>;

PolygonSoup parse(const std::string& name, const std::string& bytes) {
    const std::filesystem::path file = test_out(name);
    write_bytes(file, bytes);
    return read_polygon_soup(file);
}

std::string complaint(const std::string& name, const std::string& bytes) {
    const std::string text = error_text<InputError>([&] { parse(name, bytes); });
    return text.substr(test_out("").string().size());
}

/// What a test paints on a polygon: linear in the position, different on each polygon, so that all
/// edges are seams, and a corner that got another polygon's uv is found out.
Vec2 painted(std::size_t polygon, Vec3 p) {
    return {float(polygon) + 0.25f * p.x + 0.125f * p.z, 0.5f * p.y - 0.25f * p.z};
}

PolygonSoup paint(PolygonSoup soup) {
    for (std::size_t f = 0; f < soup.polygons.size(); ++f)
        for (const auto v : soup.polygons[f]) soup.uvs.push_back(painted(f, soup.vertices[v]));
    return soup;
}

/// Corners agree with one polygon a triangle; returns how many polygons are met.
std::size_t expect_painted(const TriangleMesh& mesh) {
    EXPECT_EQ(mesh.corner_uvs.size(), 3 * mesh.triangles.size());
    std::set<std::size_t> met;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3 first = mesh.vertices[mesh.triangles[t][0]];
        const auto polygon =
            std::size_t(std::lround(mesh.corner_uvs[3 * t].x - painted(0, first).x));
        met.insert(polygon);
        for (std::size_t c = 0; c < 3; ++c) {
            const Vec3 p = mesh.vertices[mesh.triangles[t][c]];
            EXPECT_LT(glm::distance(mesh.corner_uvs[3 * t + c], painted(polygon, p)), 1e-6f)
                << "triangle " << t << ", corner " << c;
        }
    }
    return met.size();
}

const std::string kObj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0.5 0.25\nvt 1\nvt -2 3e1 7\n";

TEST(MeshUvs, ReadsObj) {
    const PolygonSoup soup = parse("a.obj", kObj + "f 1/1 2/2 3/-1\nf 1/1/ 3/3 4\n");
    EXPECT_EQ(soup.uvs, (Uvs{{0.5f, 0.25f}, {1, 0}, {-2, 30}, {0.5f, 0.25f}, {-2, 30}, {0, 0}}));
    EXPECT_EQ(soup.corners_without_uv, 1u);
}

TEST(MeshUvs, ObjMayNameWhatFollowsOrIsMissingAltogether) {
    const PolygonSoup after = parse("a.obj", "f 1/3 2/2 3/1\n" + kObj);
    EXPECT_EQ(after.uvs, (Uvs{{-2, 30}, {1, 0}, {0.5f, 0.25f}}));
    const PolygonSoup without = parse("b.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1/1 2/-7 3/99\n");
    EXPECT_TRUE(without.uvs.empty());
}

TEST(MeshUvs, ObjVerticesStaySharedAcrossSeams) {
    const PolygonSoup soup = parse("a.obj", kObj + "f 1/1 2/1 3/1\nf 1/2 3/2 4/2\n");
    EXPECT_EQ(soup.vertices.size(), 4u);
    EXPECT_EQ(soup.uvs[0], Vec2(0.5f, 0.25f));
    EXPECT_EQ(soup.uvs[3], Vec2(1, 0));
}

TEST(MeshUvs, RefusesWrongObj) {
    EXPECT_EQ(complaint("a.obj", kObj + "f 1/1 2/4 3/1\n"),
              "a.obj: line 8: face 0: texture coordinate 4 out of range (3 texture coordinates)");
    EXPECT_EQ(complaint("b.obj", kObj + "f 1/1 2/-4 3/1\n"),
              "b.obj: line 8: -4 counts back beyond the 3 so far");
    EXPECT_EQ(complaint("c.obj", "vt 0.5x\n"),
              "c.obj: line 1: expected a texture coordinate, got '0.5x'");
    EXPECT_EQ(complaint("d.obj", "vt\n"),
              "d.obj: line 1: expected a texture coordinate, got the end of the line");
    EXPECT_EQ(complaint("e.obj", kObj + "vt 2e9 0\nf 1/1 2/4 3/1\n"),
              "e.obj: face 0: expected texture coordinates of at most 1e+09, got (2000000000, 0)");
}

std::string ply(const std::string& vertex_uv, const std::string& face_uv) {
    return fmt::format(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\n{}element face 2\n{}property list uchar int "
        "vertex_indices\nend_header\n",
        vertex_uv, face_uv);
}
const std::string kFaceUv = "property list uchar float texcoord\nproperty int texnumber\n";

TEST(MeshUvs, ReadsPlyVertices) {
    for (const auto& [u, v] : {std::pair("s", "t"), {"u", "v"}, {"texture_u", "texture_v"}}) {
        const std::string properties = fmt::format("property float {}\nproperty double {}\n", v, u);
        const PolygonSoup soup =
            parse("a.ply", ply(properties, "") +
                               "0 0 0 .5 .25\n1 0 0 1 2\n1 1 0 3 4\n0 1 0 5 6\n3 0 1 2\n3 0 2 3\n");
        EXPECT_EQ(soup.uvs, (Uvs{{0.25f, 0.5f}, {2, 1}, {4, 3}, {0.25f, 0.5f}, {4, 3}, {6, 5}}));
        EXPECT_EQ(soup.corners_without_uv, 0u);
    }
    const std::string half = "property float s\nproperty list uchar float t\n";
    EXPECT_TRUE(parse("b.ply", ply(half, "") +
                                   "0 0 0 1 0\n1 0 0 1 0\n1 1 0 1 0\n0 1 0 1 0\n3 0 1 2\n3 0 2 3\n")
                    .uvs.empty());
}

TEST(MeshUvs, ReadsPlyFaces) {
    const std::string vertices = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    const PolygonSoup soup =
        parse("a.ply", ply("", kFaceUv) + vertices + "6 0 1 2 3 4 5 0 3 0 1 2\n0 0 3 0 2 3\n");
    EXPECT_EQ(soup.uvs, (Uvs{{0, 1}, {2, 3}, {4, 5}, {0, 0}, {0, 0}, {0, 0}}));
    EXPECT_EQ(soup.corners_without_uv, 3u);
    EXPECT_EQ(
        complaint("b.ply", ply("", kFaceUv) + vertices + "4 0 1 2 3 0 3 0 1 2\n0 0 3 0 2 3\n"),
        "b.ply: line 16: expected 6 texture coordinates for 3 corners, got 4");
}

TEST(MeshUvs, RefusesPlyThatIsNotANumber) {
    std::string bytes = ply("property float u\nproperty float v\n", "");
    bytes.replace(bytes.find("ascii"), 5, "binary_little_endian");
    const auto append = [&](auto value) {
        const auto raw = std::bit_cast<std::array<char, sizeof value>>(value);
        for (const char byte : raw) bytes.push_back(byte);
    };
    for (int v = 0; v < 4; ++v)
        for (const float x : {float(v & 1), float(v >> 1), 0.0f, 0.5f, v == 2 ? NAN : 0.5f})
            append(x);
    for (int f = 0; f < 2; ++f) {
        append(char(3));
        for (const int v : {0, 1, f + 1}) append(v);
    }
    EXPECT_EQ(complaint("a.ply", bytes),
              "a.ply: face 1: expected texture coordinates of at most 1e+09, got (0.5, nan)");
}

TEST(MeshUvs, RepairKeepsSeams) {
    const RepairedMesh shared = repair(paint(unit_cube()));
    expect_body(shared, 1);
    EXPECT_EQ(expect_painted(shared.mesh), 6u);

    PolygonSoup apart = exploded(unit_cube());  // to be welded
    const RepairedMesh welded = repair(paint(apart));
    EXPECT_EQ(welded.mesh.vertices.size(), 8u);
    EXPECT_EQ(expect_painted(welded.mesh), 6u);

    const RepairedMesh turned = repair(paint(inside_out(unit_cube())));
    EXPECT_EQ(turned.report.flipped_components, 1u);
    EXPECT_EQ(expect_painted(turned.mesh), 6u);

    EXPECT_TRUE(repair(unit_cube()).mesh.corner_uvs.empty());
}

TEST(MeshUvs, RepairFollowsPolygonsThroughAllSteps) {
    // Cubes that share an edge, one polygon turned, two repeated, a fin, an unused vertex.
    PolygonSoup soup = join(unit_cube(), box({1, 1, 0}, {2, 2, 1}));
    std::reverse(soup.polygons[3].begin(), soup.polygons[3].end());
    soup.polygons.insert(soup.polygons.begin(), soup.polygons[4]);
    soup.polygons.push_back(soup.polygons[7]);
    soup.vertices.push_back(Vec3(0.5f, 2, 0.5f));
    soup.polygons.insert(soup.polygons.begin() + 2, {1, 0, 16});
    soup.vertices.push_back(Vec3(9));
    const RepairedMesh result = repair(paint(soup));
    expect_body(result, 2, 2);
    EXPECT_EQ(result.report.duplicate_faces, 4u);
    EXPECT_EQ(result.report.fin_faces, 1u);
    EXPECT_EQ(expect_painted(result.mesh), 12u);
}

TEST(MeshUvs, VertexOnTheBorderOfAPolygonGetsWhatLiesBetween) {
    // The lower quad ends in a flat triangle where its upper edge meets a vertex of its neighbours.
    PolygonSoup soup = unit_cube();
    soup.vertices.push_back(Vec3(0.25f, 1, 0));
    soup.polygons[3] = {2, 8, 6};  // the top in three, the face below it in one
    soup.polygons.push_back({8, 7, 6});
    soup.polygons.push_back({8, 3, 7});
    soup.polygons.push_back({2, 3, 8});  // flat: closes the gap to face 0
    const RepairedMesh result = repair(paint(soup));
    expect_body(result, 1);
    EXPECT_EQ(result.report.degenerate_faces, 1u);
    EXPECT_EQ(expect_painted(result.mesh), 8u);
}

TEST(MeshUvs, MirroringSwapsCorners) {
    const TriangleMesh mesh = repair(paint(unit_cube())).mesh;
    const TriangleMesh mirrored =
        transform_mesh(mesh, {glm::mat3(-1, 0, 0, 0, 1, 0, 0, 0, 1), Vec3(0)});
    EXPECT_GT(volume(mirrored), 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t old = c == 0 ? 0 : 3 - c;
            ASSERT_EQ(mirrored.triangles[t][c], mesh.triangles[t][old]);
            EXPECT_EQ(mirrored.corner_uvs[3 * t + c], mesh.corner_uvs[3 * t + old]);
        }
}

}  // namespace
}  // namespace tallow
