// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <numbers>
#include <set>

#include "common/base/rng.h"
#include "common/geometry/mesh_repair_steps.h"
#include "tests/support/mesh_soups.h"

namespace tallow {
namespace {

TEST(MeshManifold, FastTestOfAManifoldAgreesWithItsTwin) {
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

TEST(MeshManifold, TakesNonManifoldEdgesApart) {
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

TEST(MeshManifold, BodiesThatTouchInALongEdgeBecomeTwo) {
    // Of three segments: the vertices between are torn on both sides when the edge is taken apart.
    const RepairedMesh result =
        repair(blocks({{0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {1, 1, 0}, {1, 1, 1}, {1, 1, 2}}));
    expect_body(result, 6, 2);
    EXPECT_EQ(result.mesh.vertices.size(), 2 * 16u);
    EXPECT_EQ(result.report.split_vertices, 4u);
}

TEST(MeshManifold, BodyThatTouchesItselfInAnEdgeStaysClosed) {
    // A closed chain of blocks, whose ends meet in one edge only, of two segments.
    std::set<std::array<int, 3>> cells;
    for (const int z : {0, 1})
        for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {2, 0}, {2, 1}, {1, 2}, {0, 2}, {0, 1}})
            cells.insert({x, y, z});
    expect_body(repair(blocks(cells)), 14);
}

TEST(MeshManifold, RandomBlocksComeOutClosed) {
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

TEST(MeshManifold, DropsFins) {
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

TEST(MeshManifold, LargeSheetsOnABodyStayAndNameTheirBoundary) {
    // An open box beside a closed one with which it shares an edge: no fin, but a body with a hole.
    PolygonSoup open = box({1, 1, 0}, {2, 2, 1});
    open.polygons.erase(open.polygons.begin() + 1);
    const RepairedMesh result = repair(join(unit_cube(), open));
    EXPECT_EQ(result.report.fin_faces, 0u);
    EXPECT_EQ(result.mesh.triangles.size(), 12u + 10u);
    EXPECT_EQ(result.report.boundary.substr(0, 42), "boundary loop of 4 edges, 4 long, through ");
}

TEST(MeshManifold, BodiesThatTouchInAFaceBecomeOne) {
    const RepairedMesh result = repair(join(unit_cube(), box({1, 0, 0}, {2, 1, 1})));
    expect_body(result, 2);
    EXPECT_EQ(result.report.duplicate_faces, 4u);
}

TEST(MeshManifold, BodyThatIsInTheFileInsideOutToo) {
    const RepairedMesh result = repair(join(unit_cube(), inside_out(unit_cube())));
    expect_body(result, 1);
    EXPECT_EQ(result.report.duplicate_faces, 12u);
}

TEST(MeshManifold, WallsInsideABodyStayAndNameTheirBoundary) {
    // Material on both of its sides: no surface of a body, and no copy of one.
    PolygonSoup soup = blocks({{0, 0, 0}, {1, 0, 0}});
    const PolygonSoup wall{{{1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {1, 0, 1}}, {}, {{0, 1, 2, 3}}};
    const RepairedMesh result = repair(join(soup, wall));
    EXPECT_TRUE(is_manifold(result.mesh.triangles));
    EXPECT_EQ(result.report.boundary.substr(0, 42), "boundary loop of 4 edges, 4 long, through ");
}

TEST(MeshManifold, MoebiusStripIsCutOpen) {
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

}  // namespace
}  // namespace tallow
