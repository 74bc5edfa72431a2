// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/mesh_repair.h"

#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "common/base/rng.h"
#include "tests/support/error_text.h"
#include "tests/support/mesh_soups.h"

namespace tallow {
namespace {

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
