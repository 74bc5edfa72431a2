// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/mesh_repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "common/base/errors.h"
#include "common/base/rng.h"
#include "common/geometry/mesh_repair_steps.h"
#include "tests/support/error_text.h"

namespace tallow {
namespace {

using Polygons = std::vector<std::vector<std::uint32_t>>;

/// The axis-parallel box as six quads that face outward.
PolygonSoup box(Vec3 low, Vec3 high) {
    PolygonSoup soup;
    for (int i = 0; i < 8; ++i)
        soup.vertices.push_back(
            {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
    soup.polygons = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                     {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    return soup;
}

PolygonSoup unit_cube() { return box({0, 0, 0}, {1, 1, 1}); }

/// Octahedron around the origin, its faces cut in four and moved onto the sphere `times` times.
PolygonSoup sphere(float radius, int times) {
    PolygonSoup soup{
        {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
        {},
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
    for (int i = 0; i < times; ++i) {
        Polygons finer;
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
        const auto halve = [&](std::uint32_t a, std::uint32_t b) {
            const auto next = static_cast<std::uint32_t>(soup.vertices.size());
            const auto [m, is_new] = middle.try_emplace(std::minmax(a, b), next);
            if (is_new)
                soup.vertices.push_back(glm::normalize(soup.vertices[a] + soup.vertices[b]));
            return m->second;
        };
        for (const auto& p : soup.polygons) {
            const auto ab = halve(p[0], p[1]), bc = halve(p[1], p[2]), ca = halve(p[2], p[0]);
            finer.insert(finer.end(),
                         {{p[0], ab, ca}, {ab, p[1], bc}, {ca, bc, p[2]}, {ab, bc, ca}});
        }
        soup.polygons = finer;
    }
    for (Vec3& v : soup.vertices) v *= radius;
    return soup;
}

PolygonSoup join(PolygonSoup a, const PolygonSoup& b) {
    const auto offset = static_cast<std::uint32_t>(a.vertices.size());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    a.normals.insert(a.normals.end(), b.normals.begin(), b.normals.end());
    for (auto polygon : b.polygons) {
        for (auto& v : polygon) v += offset;
        a.polygons.push_back(polygon);
    }
    return a;
}

PolygonSoup inside_out(PolygonSoup soup) {
    for (auto& polygon : soup.polygons) std::reverse(polygon.begin(), polygon.end());
    return soup;
}

/// Every polygon with vertices of its own, as in an STL file read word by word.
PolygonSoup exploded(const PolygonSoup& soup) {
    PolygonSoup result;
    for (const auto& polygon : soup.polygons) {
        result.polygons.emplace_back();
        for (const auto v : polygon) {
            result.polygons.back().push_back(static_cast<std::uint32_t>(result.vertices.size()));
            result.vertices.push_back(soup.vertices[v]);
        }
    }
    return result;
}

RepairedMesh repair(const PolygonSoup& soup, Normals normals = Normals::automatic) {
    return repair_mesh(soup, normals, "test.ply");
}

double volume(const TriangleMesh& mesh) {
    double sum = 0;
    for (const auto [a, b, c] : mesh.triangles)
        sum += glm::dot(DVec3(mesh.vertices[a]),
                        glm::cross(DVec3(mesh.vertices[b]), DVec3(mesh.vertices[c]))) /
               6;
    return sum;
}

using DirectedEdges = std::map<std::pair<std::uint32_t, std::uint32_t>, int>;

DirectedEdges directed_edges(const std::vector<Triangle>& triangles) {
    DirectedEdges uses;
    for (const Triangle& t : triangles)
        for (std::size_t c = 0; c < 3; ++c) ++uses[{t[c], t[(c + 1) % 3]}];
    return uses;
}

bool is_closed(const TriangleMesh& mesh) {
    const DirectedEdges uses = directed_edges(mesh.triangles);
    return std::all_of(uses.begin(), uses.end(), [&](const auto& e) {
        return uses.contains({e.first.second, e.first.first});
    });
}

/// Whether the triangles around a vertex hang together by edges at it: they are one fan.
bool is_one_fan(std::uint32_t vertex, std::vector<Triangle> around) {
    std::set<std::uint32_t> reached{around[0][0], around[0][1], around[0][2]};
    for (std::size_t left = around.size() + 1; left > around.size();) {
        left = around.size();
        std::erase_if(around, [&](const Triangle& t) {
            const auto near = [&](std::uint32_t v) { return v != vertex && reached.contains(v); };
            if (std::none_of(t.begin(), t.end(), near)) return false;
            reached.insert(t.begin(), t.end());
            return true;
        });
    }
    return around.empty();
}

/// The slow twin of is_oriented_manifold.
bool is_manifold(const std::vector<Triangle>& triangles) {
    for (const auto& [edge, uses] : directed_edges(triangles))
        if (uses != 1) return false;
    std::map<std::uint32_t, std::vector<Triangle>> around;
    std::set<std::set<std::uint32_t>> corners;
    for (const Triangle& t : triangles) {
        for (const std::uint32_t v : t) around[v].push_back(t);
        if (!corners.insert({t.begin(), t.end()}).second) return false;
    }
    return std::all_of(around.begin(), around.end(),
                       [](const auto& v) { return is_one_fan(v.first, v.second); });
}

void expect_body(const RepairedMesh& result, double expected_volume, std::size_t components = 1) {
    EXPECT_TRUE(is_closed(result.mesh));
    EXPECT_TRUE(is_manifold(result.mesh.triangles));
    EXPECT_NEAR(volume(result.mesh), expected_volume, 1e-9 + 1e-6 * expected_volume);
    EXPECT_EQ(result.report.boundary_loops, 0u) << result.report.boundary;
    EXPECT_EQ(result.report.components, components);
    for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
        EXPECT_GT(triangle_area(result.mesh, t), 0);
}

TEST(Mesh, NormalAndAreaOfATriangle) {
    const TriangleMesh mesh{
        {{1, 1, 1}, {3, 1, 1}, {1, 4, 1}, {1, 1e-20f, 1}}, {{0, 1, 2}, {0, 3, 1}}, {}};
    EXPECT_EQ(triangle_normal(mesh, 0), Vec3(0, 0, 1));
    EXPECT_DOUBLE_EQ(triangle_area(mesh, 0), 3);
    const TriangleMesh sliver{{{0, 0, 0}, {1, 0, 0}, {0, 1e-30f, 0}}, {{0, 1, 2}}, {}};
    EXPECT_EQ(triangle_normal(sliver, 0), Vec3(0, 0, 1));  // in float the product would vanish
    EXPECT_NEAR(triangle_area(sliver, 0), 0.5e-30, 1e-36);
}

TEST(MeshRepair, LeavesACleanMeshAlone) {
    const PolygonSoup soup = sphere(1, 2);
    const RepairedMesh result = repair(soup);
    EXPECT_FALSE(result.report.changed_anything());
    EXPECT_EQ(result.report.summary(), "clean");
    EXPECT_EQ(result.mesh.triangles.size(), soup.polygons.size());
    EXPECT_EQ(result.mesh.vertices.size(), soup.vertices.size());
    EXPECT_TRUE(result.mesh.corner_normals.empty());
    EXPECT_TRUE(is_closed(result.mesh));
}

TEST(MeshRepair, CutsPolygons) {
    const RepairedMesh result = repair(unit_cube());
    expect_body(result, 1);
    EXPECT_EQ(result.mesh.triangles.size(), 12u);
    EXPECT_EQ(result.report.summary(), "cut 6 polygons into triangles");
}

TEST(MeshRepair, CutsConcavePolygonsAlongTheInside) {
    // A prism over an L: 3 unit squares.
    PolygonSoup soup;
    const std::vector<Vec2> outline = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    for (const float z : {0.0f, 1.0f})
        for (const Vec2 p : outline) soup.vertices.push_back({p.x, p.y, z});
    soup.polygons = {{5, 4, 3, 2, 1, 0}, {6, 7, 8, 9, 10, 11}};
    for (std::uint32_t i = 0; i < 6; ++i) {
        const std::uint32_t j = (i + 1) % 6;
        soup.polygons.push_back({i, j, j + 6, i + 6});
    }
    const RepairedMesh result = repair(soup);
    expect_body(result, 3);
    double area = 0;  // larger if a triangle were outside the L
    for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
        area += triangle_area(result.mesh, t);
    EXPECT_NEAR(area, 2 * 3 + 8, 1e-6);
}

TEST(MeshRepair, JoinsCoincidentVertices) {
    const RepairedMesh result = repair(exploded(unit_cube()));
    expect_body(result, 1);
    EXPECT_EQ(result.mesh.vertices.size(), 8u);
    EXPECT_EQ(result.report.merged_vertices, 24u - 8u);
}

TEST(MeshRepair, DropsUnusedVerticesAndDuplicateFaces) {
    PolygonSoup soup = unit_cube();
    soup.vertices.push_back({9, 9, 9});
    soup.polygons.push_back({3, 1, 0, 2});  // the first face, from another corner
    soup.polygons.push_back({4, 6, 7, 5});  // the second face, reversed
    const RepairedMesh result = repair(soup);
    expect_body(result, 1);
    EXPECT_EQ(result.report.summary(),
              "dropped 1 unused vertex, dropped 4 duplicate faces, cut 8 polygons into triangles");
}

TEST(MeshRepair, TurnsFacesAsTheirNeighbours) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        PolygonSoup soup = sphere(2, 2);
        std::size_t turned = 0;
        for (std::size_t f = 0; f < soup.polygons.size(); ++f)
            if (random_bits(seed, 0, f) % 3 == 0) {
                std::swap(soup.polygons[f][0], soup.polygons[f][1]);
                ++turned;
            }
        const RepairedMesh result = repair(soup);
        expect_body(result, volume(repair(sphere(2, 2)).mesh));
        EXPECT_EQ(result.report.flipped_faces, turned) << "seed " << seed;
        EXPECT_EQ(result.report.flipped_components, 0u) << "seed " << seed;
    }
}

TEST(MeshRepair, TurnsComponentsThatAreInsideOut) {
    const RepairedMesh result = repair(join(unit_cube(), inside_out(box({5, 0, 0}, {7, 2, 2}))));
    expect_body(result, 1 + 8, 2);
    EXPECT_EQ(result.report.flipped_components, 1u);
    EXPECT_EQ(result.report.flipped_faces, 0u);
}

TEST(MeshRepair, ShellOfACavityFacesIntoTheCavity) {
    // A ball in the hollow of a ball, whatever way the file turns the three shells.
    const PolygonSoup outer = sphere(3, 2), hollow = sphere(2, 2), core = sphere(1, 2);
    const auto ball = [](const PolygonSoup& soup) { return volume(repair(soup).mesh); };
    const double expected = ball(outer) - ball(hollow) + ball(core);
    for (int turn = 0; turn < 8; ++turn) {
        const auto as = [&](const PolygonSoup& s, int bit) {
            return turn & bit ? inside_out(s) : s;
        };
        const RepairedMesh result = repair(join(join(as(hollow, 1), as(outer, 2)), as(core, 4)));
        expect_body(result, expected, 3);
        const std::size_t flips = (turn & 1 ? 0 : 1) + (turn & 2 ? 1 : 0) + (turn & 4 ? 1 : 0);
        EXPECT_EQ(result.report.flipped_components, flips) << "turn " << turn;
    }
}

TEST(MeshRepair, PartsThatCrossAreNoCavities) {
    const RepairedMesh result = repair(join(box({0, 0, 0}, {4, 4, 4}), box({1, 1, 1}, {2, 2, 6})));
    expect_body(result, 64 + 5, 2);
}

TEST(MeshRepair, TakesNonManifoldEdgesApart) {
    // Two cubes that share an edge, two that share a corner.
    for (const Vec3 corner : {Vec3(1, 1, 0), Vec3(1, 1, 1)}) {
        const RepairedMesh result = repair(join(unit_cube(), box(corner, corner + Vec3(1))));
        expect_body(result, 2, 2);
        EXPECT_EQ(result.mesh.vertices.size(), 16u);
        EXPECT_GT(result.report.split_vertices, 0u);
    }
}

/// The surface of unit cubes on a grid, a quad each side that no other cube hides.
PolygonSoup blocks(const std::set<std::array<int, 3>>& cells) {
    PolygonSoup soup;
    const PolygonSoup cube = unit_cube();
    const int side[6][3] = {{0, 0, -1}, {0, 0, 1}, {0, -1, 0}, {0, 1, 0}, {-1, 0, 0}, {1, 0, 0}};
    for (const auto [x, y, z] : cells)
        for (std::size_t f = 0; f < 6; ++f) {
            if (cells.contains({x + side[f][0], y + side[f][1], z + side[f][2]})) continue;
            PolygonSoup quad{{}, {}, {{0, 1, 2, 3}}};
            for (const auto v : cube.polygons[f])
                quad.vertices.push_back(cube.vertices[v] + Vec3(x, y, z));
            soup = join(soup, quad);
        }
    return soup;
}

TEST(MeshRepair, BodiesThatTouchInALongEdgeBecomeTwo) {
    // Of three segments: the vertices between are torn on both sides when the edge is taken apart.
    const RepairedMesh result =
        repair(blocks({{0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {1, 1, 0}, {1, 1, 1}, {1, 1, 2}}));
    expect_body(result, 6, 2);
    EXPECT_EQ(result.mesh.vertices.size(), 2 * 16u);
    EXPECT_EQ(result.report.split_vertices, 4u);
}

TEST(MeshRepair, BodyThatTouchesItselfInAnEdgeStaysClosed) {
    // A closed chain of blocks, whose ends meet in one edge only, of two segments.
    std::set<std::array<int, 3>> cells;
    for (const int z : {0, 1})
        for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {2, 0}, {2, 1}, {1, 2}, {0, 2}, {0, 1}})
            cells.insert({x, y, z});
    expect_body(repair(blocks(cells)), 14);
}

TEST(MeshRepair, RandomBlocksComeOutClosed) {
    // They touch in edges and corners in every way there is.
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        std::set<std::array<int, 3>> cells;
        for (int i = 0; i < 64; ++i)
            if (random_bits(seed, 3, static_cast<std::uint64_t>(i)) % 2)
                cells.insert({i % 4, i / 4 % 4, i / 16});
        const RepairedMesh result = repair(blocks(cells));
        EXPECT_TRUE(is_manifold(result.mesh.triangles)) << "seed " << seed;
        EXPECT_EQ(result.report.boundary_loops, 0u) << "seed " << seed;
        EXPECT_NEAR(volume(result.mesh), static_cast<double>(cells.size()), 1e-9);
    }
}

TEST(MeshRepair, DropsFins) {
    const PolygonSoup cube = box({0, 0, 0}, {4, 4, 4});
    const auto with = [&](const Polygons& polygons) {
        PolygonSoup soup = cube;
        soup.vertices.insert(soup.vertices.end(), {{6, 0, 5}, {7, 2, 6}, {5, -1, 7}});  // 8, 9, 10
        soup.polygons.insert(soup.polygons.end(), polygons.begin(), polygons.end());
        return repair(soup);
    };
    // On the edge 4-5: a triangle, one seen from both sides, a sheet, a sheet from edge to edge.
    const std::vector<std::pair<Polygons, std::string>> cases = {
        {{{4, 5, 8}}, "dropped 1 face of a fin"},
        {{{4, 5, 8}, {5, 4, 8}}, "dropped 2 duplicate faces"},
        {{{4, 5, 8}, {8, 5, 9}, {8, 9, 10}}, "dropped 3 faces of fins"},
        {{{4, 5, 8}, {8, 5, 7}}, "dropped 2 faces of fins"}};
    for (const auto& [fin, dropped] : cases) {
        const RepairedMesh result = with(fin);
        expect_body(result, 64);
        EXPECT_TRUE(result.report.summary().find(dropped) != std::string::npos)
            << result.report.summary();
        EXPECT_EQ(result.mesh.triangles.size(), 12u);
    }
}

TEST(MeshRepair, LargeSheetsOnABodyStayAndNameTheirBoundary) {
    // An open box beside a closed one with which it shares an edge: no fin, but a body with a hole.
    PolygonSoup open = box({1, 1, 0}, {2, 2, 1});
    open.polygons.erase(open.polygons.begin() + 1);
    const RepairedMesh result = repair(join(unit_cube(), open));
    EXPECT_EQ(result.report.fin_faces, 0u);
    EXPECT_EQ(result.mesh.triangles.size(), 12u + 10u);
    EXPECT_EQ(result.report.boundary.substr(0, 42), "boundary loop of 4 edges, 4 long, through ");
}

TEST(MeshRepair, BodiesThatTouchInAFaceBecomeOne) {
    const RepairedMesh result = repair(join(unit_cube(), box({1, 0, 0}, {2, 1, 1})));
    expect_body(result, 2);
    EXPECT_EQ(result.report.duplicate_faces, 4u);
}

TEST(MeshRepair, BodyThatIsInTheFileInsideOutToo) {
    const RepairedMesh result = repair(join(unit_cube(), inside_out(unit_cube())));
    expect_body(result, 1);
    EXPECT_EQ(result.report.duplicate_faces, 12u);
}

TEST(MeshRepair, WallsInsideABodyStayAndNameTheirBoundary) {
    // Material on both of its sides: no surface of a body, and no copy of one.
    PolygonSoup soup = blocks({{0, 0, 0}, {1, 0, 0}});
    const PolygonSoup wall{{{1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {1, 0, 1}}, {}, {{0, 1, 2, 3}}};
    const RepairedMesh result = repair(join(soup, wall));
    EXPECT_TRUE(is_manifold(result.mesh.triangles));
    EXPECT_EQ(result.report.boundary.substr(0, 42), "boundary loop of 4 edges, 4 long, through ");
}

TEST(MeshRepair, MoebiusStripIsCutOpen) {
    PolygonSoup strip;
    constexpr std::uint32_t kSteps = 9;
    for (std::uint32_t i = 0; i < kSteps; ++i) {
        const double a = 2 * std::numbers::pi * i / kSteps;
        for (const double side : {-0.3, 0.3}) {
            const double r = 1 + side * std::cos(a / 2);
            strip.vertices.push_back(
                Vec3(DVec3(r * std::cos(a), r * std::sin(a), side * std::sin(a / 2))));
        }
        const std::uint32_t a0 = 2 * i, b0 = a0 + 1;
        const bool last = i + 1 == kSteps;
        const std::uint32_t a1 = last ? 1 : a0 + 2, b1 = last ? 0 : b0 + 2;
        strip.polygons.push_back({a0, a1, b1, b0});
    }
    const RepairedMesh result = repair(strip);
    EXPECT_TRUE(is_manifold(result.mesh.triangles));
    EXPECT_EQ(result.report.boundary_loops, 1u);
    EXPECT_EQ(result.report.split_vertices, 2u);  // a strip with two ends
    EXPECT_EQ(result.mesh.triangles.size(), 2 * kSteps);
}

TEST(MeshRepair, FastTestOfAManifoldAgreesWithItsTwin) {
    std::size_t manifolds = 0;
    for (std::uint64_t seed = 0; seed < 20000; ++seed) {
        TriangleSoup soup{std::vector<Vec3>(6), {}};
        const auto vertex = [&](std::uint64_t i) {
            return static_cast<std::uint32_t>(random_bits(seed, 5, i) % 6);
        };
        for (std::uint64_t i = 0; i < 3 * (1 + seed % 5); i += 3)
            if (const Triangle t = {vertex(i), vertex(i + 1), vertex(i + 2)};
                t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
                soup.triangles.push_back(t);
        const bool expected = is_manifold(soup.triangles);
        ASSERT_EQ(is_oriented_manifold(soup), expected) << "seed " << seed;
        manifolds += expected;
    }
    EXPECT_GT(manifolds, 2000u);
    EXPECT_LT(manifolds, 18000u);
}

TEST(MeshRepair, ChainsOfFlatTrianglesCloseUp) {
    // The edge 0-1 of the cube has three more vertices for the front, none for the floor; flat
    // triangles of all sizes fill the gap.
    PolygonSoup soup = unit_cube();
    for (const float x : {0.25f, 0.5f, 0.75f}) soup.vertices.push_back({x, 0, 0});  // 8, 9, 10
    soup.polygons[2] = {0, 8, 9, 10, 1, 5, 4};
    soup.polygons.insert(soup.polygons.end(), {{0, 1, 9}, {0, 9, 8}, {9, 1, 10}});
    const RepairedMesh result = repair(soup);
    expect_body(result, 1);
    EXPECT_EQ(result.report.degenerate_faces, 3u);
}

TEST(MeshRepair, ManyFlatTrianglesOnOneLineTakeBoundedTime) {
    // Each splits others again; without a limit their number would grow and grow.
    PolygonSoup soup{{{0, 1, 0}}, {}, {}};
    for (int i = 0; i < 60; ++i) soup.vertices.push_back({static_cast<float>(i), 0, 0});
    for (std::uint64_t i = 0; i < 3000; ++i) {
        const auto on_line = [&](std::uint64_t k) {
            return static_cast<std::uint32_t>(1 + random_bits(i, 9, k) % 60);
        };
        soup.polygons.push_back({on_line(0), on_line(1), on_line(2)});
    }
    soup.polygons.push_back({0, 1, 60});
    const RepairedMesh result = repair(soup);
    EXPECT_TRUE(is_manifold(result.mesh.triangles));
    EXPECT_LT(result.mesh.triangles.size(), 60u);
}

TEST(MeshRepair, CutsPolygonsWithThousandsOfCorners) {
    // A star's outline (the worst case: half of its corners are reflex), and a scribble.
    PolygonSoup star, scribble;
    star.polygons.emplace_back();
    scribble.polygons.emplace_back();
    double area = 0;
    for (std::uint32_t i = 0; i < kMostCorners; ++i) {
        const double a = 2 * std::numbers::pi * i / kMostCorners, r = i % 2 ? 1 : 0.5;
        star.vertices.push_back(Vec3(DVec3(r * std::cos(a), r * std::sin(a), 0)));
        star.polygons[0].push_back(i);
        area += 0.5 * 0.5 * std::sin(2 * std::numbers::pi / kMostCorners);
        const auto random = [&](std::uint64_t k) {
            return static_cast<float>(random_bits(i, 13, k) % 1000);
        };
        scribble.vertices.push_back({random(0), random(1), random(2)});
        scribble.polygons[0].push_back(i);
    }
    const RepairedMesh result = repair(star);
    EXPECT_EQ(result.mesh.triangles.size(), kMostCorners - 2);
    double sum = 0;  // larger if triangles overlapped
    for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
        sum += triangle_area(result.mesh, t);
    EXPECT_NEAR(sum, area, 1e-7);  // measured 7e-9: the vertices are float
    EXPECT_TRUE(is_manifold(repair(scribble).mesh.triangles));
}

TEST(MeshRepair, RemovingDegenerateFacesOpensNothing) {
    // The cube's edge 0-1 has a vertex in its middle that only one side knows; a triangle of no
    // area fills the gap. And one face with a repeated corner.
    PolygonSoup soup = unit_cube();
    soup.vertices.push_back({0.5f, 0, 0});
    soup.polygons[0] = {0, 2, 3, 1, 8};
    soup.polygons.push_back({0, 8, 1});
    soup.polygons.push_back({2, 2, 3});
    const RepairedMesh result = repair(soup);
    expect_body(result, 1);
    EXPECT_GE(result.report.degenerate_faces, 2u);
}

TEST(MeshRepair, NamesTheBoundary) {
    PolygonSoup soup = box({0, 0, 0}, {2, 3, 4});
    soup.polygons.erase(soup.polygons.begin() + 1);  // the lid: 2 x 3 at z = 4
    RepairedMesh result = repair(soup);
    EXPECT_EQ(result.report.boundary_loops, 1u);
    EXPECT_EQ(result.report.boundary.substr(0, 43), "boundary loop of 4 edges, 10 long, through ");
    EXPECT_NE(result.report.boundary.find(", 4)"), std::string::npos) << result.report.boundary;
    EXPECT_EQ(result.report.summary(),
              "cut 5 polygons into triangles, open: " + result.report.boundary);

    soup.polygons.erase(soup.polygons.begin());  // the floor: as long, found second or first
    result = repair(soup);
    EXPECT_EQ(result.report.boundary_loops, 2u);
    EXPECT_EQ(result.report.boundary.substr(0, 58),
              "2 boundary loops, the longest of 4 edges, 10 long, through");
}

TEST(MeshRepair, RefusesWhatHasNoArea) {
    const PolygonSoup needle{{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {}, {{0, 1, 2}}};
    EXPECT_EQ(error_text<InputError>([&] { repair(needle); }),
              "test.ply: no face of this mesh has an area");
}

TEST(MeshRepair, SmoothNormalsWithoutAFileAreAngleWeighted) {
    const RepairedMesh result = repair(unit_cube(), Normals::smooth);
    ASSERT_EQ(result.mesh.corner_normals.size(), 36u);
    for (std::size_t i = 0; i < 36; ++i) {
        // Three right angles meet in each corner, however its faces are cut.
        const Vec3 p = result.mesh.vertices[result.mesh.triangles[i / 3][i % 3]];
        const Vec3 expected = glm::normalize(p - Vec3(0.5f));
        EXPECT_LT(glm::distance(result.mesh.corner_normals[i], expected), 1e-6f);
    }
}

/// The cube with a vertex and a normal for each corner of each face: creases at all edges.
PolygonSoup creased_cube() {
    PolygonSoup soup = exploded(unit_cube());
    for (const Vec3 n : {Vec3(0, 0, -1), Vec3(0, 0, 1), Vec3(0, -1, 0), Vec3(0, 1, 0),
                         Vec3(-1, 0, 0), Vec3(1, 0, 0)})
        for (int corner = 0; corner < 4; ++corner) soup.normals.push_back(7.0f * n);
    return soup;
}

void expect_corner_normals_are_flat(const TriangleMesh& mesh) {
    ASSERT_EQ(mesh.corner_normals.size(), 3 * mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.corner_normals.size(); ++i)
        EXPECT_EQ(mesh.corner_normals[i], triangle_normal(mesh, i / 3));
}

TEST(MeshRepair, KeepsSplitNormalsOfTheFile) {
    const RepairedMesh result = repair(creased_cube());
    expect_body(result, 1);
    expect_corner_normals_are_flat(result.mesh);
    EXPECT_TRUE(repair(creased_cube(), Normals::flat).mesh.corner_normals.empty());
}

TEST(MeshRepair, NormalsTurnWithTheirComponent) {
    PolygonSoup soup = inside_out(creased_cube());
    expect_corner_normals_are_flat(repair(soup).mesh);  // the normals were right, the faces wrong
    for (Vec3& n : soup.normals) n = -n;
    expect_corner_normals_are_flat(repair(soup).mesh);  // both were wrong
}

TEST(MeshRepair, ReplacesNormalsThatFaceAwayOrAreMissing) {
    PolygonSoup soup = sphere(1, 2);
    soup.normals = soup.vertices;
    soup.normals[3] = -soup.normals[3];
    soup.normals[4] = Vec3(0);
    const TriangleMesh mesh = repair(soup).mesh;
    for (std::size_t i = 0; i < mesh.corner_normals.size(); ++i) {
        EXPECT_NEAR(glm::length(mesh.corner_normals[i]), 1, 1e-6f);
        const Vec3 p = mesh.vertices[mesh.triangles[i / 3][i % 3]];
        EXPECT_LT(glm::distance(mesh.corner_normals[i], p), 1e-6f);  // by symmetry also the means
    }
}

// Random polygons over few points: everything that can be wrong is wrong at once.
TEST(MeshRepair, SurvivesRandomSoups) {
    std::size_t meshes = 0;
    for (std::uint64_t seed = 0; seed < 2000; ++seed) {
        std::uint64_t draws = 0;
        const auto random = [&](std::uint32_t n) { return random_bits(seed, 7, draws++) % n; };
        PolygonSoup soup;
        const std::uint32_t points = 4 + random(12), polygons = 1 + random(20);
        for (std::uint32_t i = 0; i < points; ++i) {
            const auto coordinate = [&] {
                return static_cast<float>(random(3)) * (random(50) ? 1 : 1e30f);
            };
            const float x = coordinate(), y = coordinate(), z = coordinate();
            soup.vertices.push_back({x, y, z});
            soup.normals.push_back({y - 1, z - 1, x});
        }
        for (std::uint32_t p = 0; p < polygons; ++p) {
            soup.polygons.emplace_back(3 + random(4));
            for (auto& v : soup.polygons.back()) v = random(points);
        }
        try {
            const RepairedMesh result = repair(soup);
            ASSERT_TRUE(is_manifold(result.mesh.triangles)) << "seed " << seed;
            EXPECT_EQ(is_closed(result.mesh), result.report.boundary_loops == 0) << "seed " << seed;
            for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
                ASSERT_GT(triangle_area(result.mesh, t), 0) << "seed " << seed;
            for (const Vec3 n : result.mesh.corner_normals)
                ASSERT_NEAR(glm::length(n), 1, 1e-5f) << "seed " << seed;
            ++meshes;
        } catch (const InputError&) {
        }
    }
    EXPECT_GT(meshes, 1500u);
}

}  // namespace
}  // namespace tallow
