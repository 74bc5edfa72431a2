// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/mesh_io.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>

#include "common/base/errors.h"
#include "common/base/rng.h"
#include "tests/support/error_text.h"
#include "tests/support/test_files.h"

namespace tallow {
namespace {

using Polygons = std::vector<std::vector<std::uint32_t>>;

PolygonSoup parse(const std::string& name, const std::string& bytes) {
    const std::filesystem::path file = test_out(name);
    write_bytes(file, bytes);
    return read_polygon_soup(file);
}

/// The message of the InputError that reading throws, without the folder.
std::string complaint(const std::string& name, const std::string& bytes) {
    const std::string text = error_text<InputError>([&] { parse(name, bytes); });
    const std::string folder = test_out("").string();
    return text.starts_with(folder) ? text.substr(folder.size()) : text;
}

template <class T>
std::string bytes_of(T value, std::endian order = std::endian::little) {
    std::string raw(sizeof(T), '\0');
    std::memcpy(raw.data(), &value, sizeof(T));
    if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
    return raw;
}

std::string with_crlf(const std::string& text) {
    std::string result;
    for (const char c : text) result += c == '\n' ? std::string("\r\n") : std::string(1, c);
    return result;
}

// A triangle, a quad and a pentagon over six vertices.
const std::vector<Vec3> kVertices = {{0, 0, 0}, {1, 0, 0},         {1.5f, 1, 0},
                                     {1, 2, 0}, {-0.25f, 2e1f, 0}, {0, 1, -3}};
const Polygons kPolygons = {{0, 1, 5}, {1, 2, 3, 5}, {0, 1, 2, 3, 4}};

void expect_shape(const PolygonSoup& soup) {
    EXPECT_EQ(soup.vertices, kVertices);
    EXPECT_EQ(soup.polygons, kPolygons);
}

const std::string kOff =
    "OFF\n6 3 0\n0 0 0\n1 0 0\n1.5 1 0\n1 2 0\n-.25 2e1 0\n+0 1 -3\n"
    "3 0 1 5\n4 1 2 3 5\n5 0 1 2 3 4\n";
const std::string kObj =
    "v 0 0 0\nv 1 0 0\nv 1.5 1 0\nv 1 2 0\nv -.25 2e1 0\nv 0 1 -3\n"
    "f 1 2 6\nf 2 3 4 6\nf 1 2 3 4 5\n";

std::string ply_header(const std::string& format, const std::string& normals = "") {
    return "ply\nformat " + format +
           " 1.0\ncomment by hand\nelement vertex 6\nproperty float x\nproperty float y\n"
           "property float z\n" +
           normals + "element face 3\nproperty list uchar int vertex_indices\nend_header\n";
}

const std::string kAsciiPly = ply_header("ascii") + kOff.substr(kOff.find("0 0 0\n1"));

std::string binary_ply(std::endian order) {
    std::string bytes =
        ply_header(order == std::endian::little ? "binary_little_endian" : "binary_big_endian");
    for (const Vec3 v : kVertices)
        for (int axis = 0; axis < 3; ++axis) bytes += bytes_of(v[axis], order);
    for (const auto& polygon : kPolygons) {
        bytes += bytes_of(static_cast<std::uint8_t>(polygon.size()), order);
        for (const std::uint32_t v : polygon) bytes += bytes_of(v, order);
    }
    return bytes;
}

const std::string kObjUvs = "vt 0 0\nvt 1 .5\nvt -3 7e2\nf 1/1 2/-1 3/2\nf 2/1 3/1 4\n";

std::string textured_ply() {
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nproperty float s\nproperty float t\nelement face 2\n"
        "property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n";
    for (int i = 0; i < 15; ++i) bytes += bytes_of(static_cast<float>(i * i % 7));
    for (const int corners : {3, 0}) {
        bytes += bytes_of(std::uint8_t{3});
        for (const int v : {0, 1, 2}) bytes += bytes_of(v);
        bytes += bytes_of(static_cast<std::uint8_t>(2 * corners));
        for (int i = 0; i < 2 * corners; ++i) bytes += bytes_of(0.25f * static_cast<float>(i));
    }
    return bytes;
}

// Two triangles that share an edge: four different corners.
const std::vector<Vec3> kFourCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.5f}};
const Polygons kTwoTriangles = {{0, 1, 2}, {2, 1, 3}};

const std::string kAsciiStl =
    "solid two triangles\n"
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    "facet normal 0 0 1\nouter loop\nvertex 0 1 0\nvertex 1 0 0\nvertex 1 1 "
    "5e-1\nendloop\nendfacet\n"
    "endsolid two triangles\n";

std::string binary_stl(const std::string& title = "binary") {
    std::string bytes = title;
    bytes.resize(80, '\0');
    bytes += bytes_of(std::uint32_t{2});
    for (const auto& triangle : kTwoTriangles) {
        bytes += std::string(12, '\0');
        for (const std::uint32_t v : triangle)
            for (int axis = 0; axis < 3; ++axis) bytes += bytes_of(kFourCorners[v][axis]);
        bytes += std::string(2, '\0');
    }
    return bytes;
}

void expect_two_triangles(const PolygonSoup& soup) {
    EXPECT_EQ(soup.vertices, kFourCorners);
    EXPECT_EQ(soup.polygons, kTwoTriangles);
}

TEST(MeshIo, ReadsOff) {
    expect_shape(parse("shape.off", kOff));
    expect_shape(parse("SHAPE.OFF", with_crlf(kOff)));
    expect_shape(parse("comments.off", "# by hand\nOFF # magic\n\n# counts\n" + kOff.substr(4)));
    expect_shape(parse("same_line.off", "OFF " + kOff.substr(4)));
    expect_shape(parse("no_last_line_end.off", kOff.substr(0, kOff.size() - 1)));
}

TEST(MeshIo, ReadsOffWithColoursAndNormals) {
    const PolygonSoup soup = parse("colours.off",
                                   "CNOFF\n3 1 3\n0 0 0 0 0 1 255 0 0\n1 0 0 0 1 0 0 255 0\n"
                                   "0 1 0 1 0 0 0 0 255\n3 0 1 2 0.5 0.5 0.5\n");
    EXPECT_EQ(soup.normals, (std::vector<Vec3>{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}}));
    EXPECT_EQ(soup.polygons, (Polygons{{0, 1, 2}}));
}

TEST(MeshIo, ReadsObj) {
    expect_shape(parse("shape.obj", kObj));
    expect_shape(parse("shape_crlf.obj", with_crlf("# by hand\nmtllib a.mtl\no shape\n" + kObj)));
    const std::string from_the_end =
        kObj.substr(0, kObj.find('f')) + "f -6 -5 -1\nf 2/1 3/2 4/-1 6/1\nf 1/ 2/ 3/ \\\n 4/ 5/\n";
    expect_shape(parse("relative.obj", from_the_end));
    const std::size_t faces = kObj.find('f');
    expect_shape(parse("faces_first.obj", kObj.substr(faces) + kObj.substr(0, faces)));
}

TEST(MeshIo, ObjVerticesAreSplitByNormal) {
    const PolygonSoup soup = parse("normals.obj",
                                   "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nvn 0 0 1\nvn 0 1 0\n"
                                   "f 1//1 2//1 3/7/1\nf 3//2 2//1 4\n");
    EXPECT_EQ(soup.polygons, (Polygons{{0, 1, 2}, {4, 1, 3}}));
    ASSERT_EQ(soup.vertices.size(), 5u);
    EXPECT_EQ(soup.vertices[4], soup.vertices[2]);
    EXPECT_EQ(soup.normals,
              (std::vector<Vec3>{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 0}, {0, 1, 0}}));
}

TEST(MeshIo, ReadsPly) {
    expect_shape(parse("shape.ply", kAsciiPly));
    expect_shape(parse("shape_crlf.ply", with_crlf(kAsciiPly)));
    expect_shape(parse("shape_le.ply", binary_ply(std::endian::little)));
    expect_shape(parse("shape_be.ply", binary_ply(std::endian::big)));
}

TEST(MeshIo, ReadsPlyWithOtherPropertiesAndElements) {
    const PolygonSoup soup = parse(
        "rich.ply",
        "ply\nformat ascii 1.0\nelement camera 1\nproperty list int float matrix\n"
        "element face 1\nproperty uchar red\nproperty list uint8 uint32 vertex_index\n"
        "element vertex 3\nproperty double z\nproperty double x\nproperty int y\n"
        "property float nx\nproperty float ny\nproperty float nz\nproperty list uchar int extra\n"
        "end_header\n2 0.5 0.5\n255 3 2 1 0\n9 1 2 0 0 1 0\n9 3 4 0 1 0 2 7 7\n9 5 6 1 0 0 0\n");
    EXPECT_EQ(soup.vertices, (std::vector<Vec3>{{1, 2, 9}, {3, 4, 9}, {5, 6, 9}}));
    EXPECT_EQ(soup.normals, (std::vector<Vec3>{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}}));
    EXPECT_EQ(soup.polygons, (Polygons{{2, 1, 0}}));
}

TEST(MeshIo, ReadsStlAndSharesVertices) {
    expect_two_triangles(parse("two.stl", kAsciiStl));
    expect_two_triangles(parse("two_crlf.stl", with_crlf(kAsciiStl)));
    expect_two_triangles(parse("two_binary.stl", binary_stl()));
    expect_two_triangles(parse("two_binary_solid.stl", binary_stl("solid but binary")));
}

struct BadFile {
    std::string name, bytes, complaint;
};

std::ostream& operator<<(std::ostream& out, const BadFile& bad) { return out << bad.name; }

class MeshIoRefuses : public testing::TestWithParam<BadFile> {};

TEST_P(MeshIoRefuses, WithALocatedMessage) {
    EXPECT_EQ(complaint(GetParam().name, GetParam().bytes),
              GetParam().name + ": " + GetParam().complaint);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
}

const std::string kLittlePly = binary_ply(std::endian::little);

INSTANTIATE_TEST_SUITE_P(
    Any, MeshIoRefuses,
    testing::Values(BadFile{"empty.ply", "", "expected a mesh, got an empty file"},
                    BadFile{"mesh.vrml", "OFF",
                            "expected a mesh file .ply, .obj, .off or .stl, got '.vrml'"},
                    BadFile{"mesh", "OFF", "expected a mesh file .ply, .obj, .off or .stl, got ''"},
                    BadFile{"points.obj", "v 0 0 0\n", "expected at least one face, got none"}));

INSTANTIATE_TEST_SUITE_P(
    Off, MeshIoRefuses,
    testing::Values(BadFile{"magic.off", "FOO\n",
                            "line 1: expected 'OFF', 'COFF', 'NOFF' or 'CNOFF', got 'FOO'"},
                    BadFile{"binary.off", "OFF BINARY\n\1\2\3",
                            "line 1: expected a number of vertices, got 'BINARY'"},
                    BadFile{"word.off", replaced(kOff, "1.5 1 0", "1.5 one 0"),
                            "line 5: expected a coordinate, got 'one'"},
                    BadFile{"unit.off", replaced(kOff, "1.5 1 0", "1.5mm 1 0"),
                            "line 5: expected a coordinate, got '1.5mm'"},
                    BadFile{"nan.off", replaced(kOff, "1.5 1 0", "nan 1 0"),
                            "line 5: expected a coordinate, got 'nan'"},
                    BadFile{"huge.off", replaced(kOff, "1.5 1 0", "1e39 1 0"),
                            "line 5: expected a coordinate, got '1e39'"},
                    BadFile{"short.off", replaced(kOff, "1.5 1 0", "1.5 1"),
                            "line 5: expected a coordinate, got the end of the line"},
                    BadFile{"range.off", replaced(kOff, "4 1 2 3 5", "4 1 2 3 6"),
                            "face 1: vertex 6 out of range (6 vertices)"},
                    BadFile{"negative.off", replaced(kOff, "4 1 2 3 5", "4 1 2 3 -5"),
                            "line 10: expected a vertex index, got -5"},
                    BadFile{"edge.off", replaced(kOff, "3 0 1 5", "2 0 1"),
                            "line 9: expected at least three corners, got 2"},
                    BadFile{"corners.off", replaced(kOff, "4 1 2 3 5", "2000000000 1 2 3 5"),
                            "line 10: expected a vertex index, got the end of the line"},
                    BadFile{"promise.off", replaced(kOff, "6 3 0", "6 4 0"),
                            "line 11: expected face 3 of 4, got the end of the file"},
                    BadFile{"counts.off", replaced(kOff, "6 3 0", "6 4000000000 0"),
                            "line 2: 4000000000 faces do not fit in the 75 bytes that follow"},
                    BadFile{"more.off", kOff + "3 0 1 2\n",
                            "line 12: expected the end of the file, got '3'"}));

INSTANTIATE_TEST_SUITE_P(
    Obj, MeshIoRefuses,
    testing::Values(BadFile{"range.obj", replaced(kObj, "f 2 3 4 6", "f 2 3 4 7"),
                            "line 8: face 1: vertex 7 out of range (6 vertices)"},
                    BadFile{"before.obj", "v 0 0 0\nf -1 -2 -3\n",
                            "line 2: -2 counts back beyond the 1 so far"},
                    BadFile{"normal.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//2\n",
                            "line 5: face 0: normal 2 out of range (1 normals)"},
                    BadFile{"zero.obj", "v 0 0 0\nf 1 0 1\n",
                            "line 2: expected a corner like 3, 3/1, 3//2 or 3/1/2, got '0'"},
                    BadFile{"slashes.obj", "v 0 0 0\nf 1/1/1/1 1 1\n",
                            "line 2: expected a corner like 3, 3/1, 3//2 or 3/1/2, got '1/1/1/1'"},
                    BadFile{"edge.obj", replaced(kObj, "f 1 2 6", "f 1 2"),
                            "line 7: expected at least three corners, got 2"},
                    BadFile{"keyword.obj", "v 0 0 0\n\x01surface\n",
                            "line 2: expected an OBJ keyword for polygons, got '?surface'"},
                    BadFile{"infinite.obj", "v 0 inf 0\n",
                            "line 1: expected a coordinate, got 'inf'"}));

INSTANTIATE_TEST_SUITE_P(
    Ply, MeshIoRefuses,
    testing::Values(
        BadFile{"magic.ply", "plyer\n", "line 1: expected 'ply', got 'plyer'"},
        BadFile{"format.ply", "ply\nformat xml 1.0\n",
                "line 2: expected 'ascii', 'binary_little_endian' or 'binary_big_endian', got "
                "'xml'"},
        BadFile{"header.ply", "ply\nformat ascii 1.0\nelement vertex 3\n",
                "line 3: expected 'end_header', got the end of the file"},
        BadFile{"type.ply", replaced(kAsciiPly, "float y", "real y"),
                "line 6: expected a PLY type such as 'float' or 'uchar', got 'real'"},
        BadFile{"twice.ply", replaced(kAsciiPly, "float y", "float x"),
                "line 6: property 'x' twice"},
        BadFile{"missing.ply", replaced(kAsciiPly, "float y", "float w"),
                "element 'vertex': expected a property 'y'"},
        BadFile{"strips.ply", replaced(kAsciiPly, "vertex_indices", "tristrips"),
                "element 'face': expected a list 'vertex_indices'"},
        BadFile{"range.ply", replaced(kAsciiPly, "4 1 2 3 5", "4 1 2 3 9"),
                "face 1: vertex 9 out of range (6 vertices)"},
        BadFile{"fraction.ply", replaced(kAsciiPly, "4 1 2 3 5", "4 1 2 3 4.5"),
                "line 18: expected an integer, got '4.5'"},
        BadFile{"rest.ply", replaced(kAsciiPly, "4 1 2 3 5", "3 1 2 3 5"),
                "line 18: expected the end of the line, got '5'"},
        BadFile{"counts.ply", replaced(kLittlePly, "vertex 6", "vertex 4000000000"),
                "element 'vertex': 4000000000 items do not fit in the 123 bytes that follow"},
        BadFile{"truncated.ply", kLittlePly.substr(0, kLittlePly.size() - 1),
                "face 2: the file ends here, 3 promised"},
        BadFile{"longer.ply", kLittlePly + "??", "2 bytes follow after the last element"},
        BadFile{
            "short_face.ply",
            replaced(kLittlePly, std::string("\3\0\0\0\0\1", 6), std::string("\2\0\0\0\0\1", 6)),
            "face 0: expected at least three corners, got 2"},
        BadFile{"infinite.ply", replaced(kLittlePly, bytes_of(-3.0f), bytes_of(kInfinity)),
                "vertex 5: expected a finite position, got (0, 1, inf)"}));

INSTANTIATE_TEST_SUITE_P(
    Stl, MeshIoRefuses,
    testing::Values(BadFile{"garbage.stl", "hello",
                            "expected 'solid' or 84 bytes of binary header, got 5 bytes"},
                    BadFile{"count.stl", binary_stl().substr(0, 150),
                            "header promises 2 triangles in 100 bytes, but 66 bytes follow"},
                    BadFile{"solid.stl", binary_stl("solid").substr(0, 184 - 50),
                            "header promises 2 triangles in 100 bytes, but 50 bytes follow"},
                    BadFile{"cut.stl", kAsciiStl.substr(0, kAsciiStl.find("endsolid")),
                            "line 15: expected 'facet' or 'endsolid', got the end of the file"},
                    BadFile{"half.stl", replaced(kAsciiStl, "vertex 1 1 5e-1\n", ""),
                            "line 13: expected 'vertex', got 'endloop'"},
                    BadFile{"word.stl", replaced(kAsciiStl, "vertex 1 0 0", "vertex 1 x 0"),
                            "line 5: expected a coordinate, got 'x'"}));

TEST(MeshIo, NamesWhatIsNoFile) {
    std::filesystem::create_directories(test_out("folder.ply"));
    const auto message = [](const std::string& name) {
        return error_text<InputError>([&] { read_polygon_soup(test_out(name)); });
    };
    EXPECT_EQ(message("absent.ply"), test_out("absent.ply").string() + ": no such file");
    EXPECT_EQ(message("folder.ply"),
              test_out("folder.ply").string() + ": expected a file, got a directory or device");
}

TEST(MeshIo, RefusesPolygonsOfTooManyCorners) {
    const auto fan = [](std::size_t corners) {
        std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf";
        for (std::size_t i = 0; i < corners; ++i)
            text += i % 3 == 0 ? " 1" : i % 3 == 1 ? " 2" : " 3";
        return text + "\n";
    };
    EXPECT_EQ(complaint("many.obj", fan(4097)),
              "many.obj: face 1: expected at most 4096 corners, got 4097; cut it into triangles");
    EXPECT_EQ(parse("many.obj", fan(4096)).polygons[1].size(), 4096u);
}

/// Flips bytes, cuts the file short, or replaces its end by the end of another.
std::string mutate(std::string bytes, const std::string& other, std::uint64_t seed) {
    const auto random = [&](std::uint64_t stream, std::size_t n) {
        return random_bits(seed, stream, 0) % std::max<std::size_t>(n, 1);
    };
    switch (random(0, 4)) {
        case 0:
            return bytes.substr(0, random(1, bytes.size()));
        case 1:
            return bytes.substr(0, random(1, bytes.size())) + other.substr(random(2, other.size()));
        default:
            for (std::size_t i = 0; i <= random(3, 4); ++i)
                bytes[random(10 + i, bytes.size())] = static_cast<char>(random(20 + i, 256));
            return bytes;
    }
}

// 300 mutants of each file; the allowed outcomes are a sound soup or InputError.
TEST(MeshIo, SurvivesMutatedFiles) {
    const std::vector<std::pair<std::string, std::string>> files = {
        {"fuzz.off", kOff},          {"fuzz.obj", kObj},
        {"fuzz.ply", kAsciiPly},     {"fuzz.ply", binary_ply(std::endian::little)},
        {"fuzz.stl", kAsciiStl},     {"fuzz.ply", binary_ply(std::endian::big)},
        {"fuzz.stl", binary_stl()},  {"fuzz.obj", kObj + kObjUvs},
        {"fuzz.ply", textured_ply()}};
    std::size_t accepted = 0, refused = 0;
    for (std::size_t f = 0; f < files.size(); ++f)
        for (std::uint64_t i = 0; i < 300; ++i) {
            const auto& [name, bytes] = files[f];
            const std::string& other = files[(f + 1 + i) % files.size()].second;
            try {
                const PolygonSoup soup = parse(name, mutate(bytes, other, 1000 * f + i));
                for (const auto& polygon : soup.polygons)
                    for (const std::uint32_t v : polygon) ASSERT_LT(v, soup.vertices.size());
                for (const Vec2 uv : soup.uvs)
                    ASSERT_TRUE(std::isfinite(uv.x) && std::isfinite(uv.y));
                ++accepted;
            } catch (const InputError&) {
                ++refused;
            }
        }
    EXPECT_GT(accepted, 50u);  // flipped coordinates are still numbers
    EXPECT_GT(refused, 500u);
}

}  // namespace
}  // namespace tallow
