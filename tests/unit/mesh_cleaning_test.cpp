// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "common/base/rng.h"
#include "common/geometry/mesh_repair_steps.h"
#include "tests/support/mesh_soups.h"

namespace tallow {
namespace {

TEST(MeshCleaning, JoinsCoincidentVertices) {
    const RepairedMesh result = repair(exploded(unit_cube()));
    expect_body(result, 1);
    EXPECT_EQ(result.mesh.vertices.size(), 8u);
    EXPECT_EQ(result.report.merged_vertices, 24u - 8u);
}

TEST(MeshCleaning, CutsPolygons) {
    const RepairedMesh result = repair(unit_cube());
    expect_body(result, 1);
    EXPECT_EQ(result.mesh.triangles.size(), 12u);
    EXPECT_EQ(result.report.summary(), "cut 6 polygons into triangles");
}

TEST(MeshCleaning, CutsConcavePolygonsAlongTheInside) {
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

TEST(MeshCleaning, CutsPolygonsWithThousandsOfCorners) {
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

TEST(MeshCleaning, RemovingDegenerateFacesOpensNothing) {
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

TEST(MeshCleaning, ChainsOfFlatTrianglesCloseUp) {
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

TEST(MeshCleaning, ManyFlatTrianglesOnOneLineTakeBoundedTime) {
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

TEST(MeshCleaning, DropsUnusedVerticesAndDuplicateFaces) {
    PolygonSoup soup = unit_cube();
    soup.vertices.push_back({9, 9, 9});
    soup.polygons.push_back({3, 1, 0, 2});  // the first face, from another corner
    soup.polygons.push_back({4, 6, 7, 5});  // the second face, reversed
    const RepairedMesh result = repair(soup);
    expect_body(result, 1);
    EXPECT_EQ(result.report.summary(),
              "dropped 1 unused vertex, dropped 4 duplicate faces, cut 8 polygons into triangles");
}

}  // namespace
}  // namespace tallow
