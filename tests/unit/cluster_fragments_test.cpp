// SPDX-License-Identifier: Apache-2.0
// What clusters must not join, and how far they may be from the surface for which they stand.
#include "precompute/cluster_fragments.h"

#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "precompute/sample_surface.h"
#include "tests/support/ball_mesh.h"
#include "tests/support/patch_meshes.h"

namespace tallow {
namespace {

/// Area of the samples whose normal is within `degrees` of n.
double area_facing(const SurfaceSamples& samples, Vec3 n, double degrees) {
    double area = 0;
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (glm::dot(samples.normal[i], n) > std::cos(glm::radians(degrees)))
            area += double(samples.area[i]);
    return area;
}

// A roof whose slopes face 44 degrees to either side of z, through the same side of a cube, and
// share the vertices of the ridge: cells may not cross it, wherever cubes and cuts happen to be.
TEST(ClusterFragments, DoNotCrossASharpEdge) {
    for (int place = 0; place < 20; ++place) {
        const float shift = 0.37f * float(place);
        const float c = std::cos(0.768f), s = std::sin(0.768f);  // 44 degrees
        TriangleMesh roof =
            test::grid_mesh({shift, shift, 0}, {10 * c, 0, -10 * s}, {0, 10, 0}, 100);
        const TriangleMesh other =
            test::grid_mesh({shift, shift, 0}, {0, 10, 0}, {-10 * c, 0, -10 * s}, 100);
        // Its first row of vertices is the ridge, which the first mesh has as its first column.
        std::vector<std::uint32_t> number(other.vertices.size());
        for (std::uint32_t i = 0; i < number.size(); ++i) {
            number[i] = std::uint32_t(roof.vertices.size());
            if (i <= 100)
                number[i] = 101 * i;
            else
                roof.vertices.push_back(other.vertices[i]);
        }
        for (const Triangle& t : other.triangles)
            roof.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});

        const SurfaceSamples samples = sample_surface(roof, 0.7f);
        // A hundredth of a cluster may face another way: measured 1e-5 of 100 mm^2.
        EXPECT_NEAR(area_facing(samples, {s, 0, c}, 20), 100, 0.1) << place;
        EXPECT_NEAR(area_facing(samples, {-s, 0, c}, 20), 100, 0.1) << place;
        EXPECT_LT(double(samples.size()), 1.15 * 200 / (0.7 * 0.7));
    }
}

// The two faces of a sheet, as a fine mesh, a tenth of the spacing apart.
TEST(ClusterFragments, KeepTheFacesOfAThinSheetApart) {
    TriangleMesh sheet = test::grid_mesh({0, 0, 0}, {0, 10, 0}, {10, 0, 0}, 100);
    test::append(sheet, test::grid_mesh({0, 0, 0.07f}, {10, 0, 0}, {0, 10, 0}, 100));
    const SurfaceSamples samples = sample_surface(sheet, 0.7f);
    EXPECT_NEAR(area_facing(samples, {0, 0, 1}, 1), 100, 1e-3);
    EXPECT_NEAR(area_facing(samples, {0, 0, -1}, 1), 100, 1e-3);
    for (std::size_t i = 0; i < samples.size(); ++i)
        EXPECT_NEAR(samples.position[i].z, samples.normal[i].z > 0 ? 0.07f : 0, 1e-6f);
}

// Two surfaces that face the same way, closer than the spacing: the upper faces of two plates, one
// on the other. Nothing but their connection tells them apart.
TEST(ClusterFragments, KeepStackedSheetsApart) {
    TriangleMesh plates = test::grid_mesh({0, 0, 0}, {10, 0, 0}, {0, 10, 0}, 100);
    test::append(plates, test::grid_mesh({0, 0, 0.1f}, {10, 0, 0}, {0, 10, 0}, 100));
    const SurfaceSamples samples = sample_surface(plates, 0.7f);
    std::size_t between = 0;
    for (const Vec3& p : samples.position) between += p.z > 1e-5f && p.z < 0.1f - 1e-5f;
    EXPECT_EQ(between, 0u);
    EXPECT_NEAR(double(samples.size()), 408, 0.1 * 408);  // area / spacing^2; measured: 430
}

/// A point of the mesh and the normal of its triangle, each triangle as likely as any other.
std::pair<Vec3, Vec3> random_point(const TriangleMesh& mesh, std::uint64_t i) {
    const std::size_t t = random_bits(1, 0, i) % mesh.triangles.size();
    float u = to_unit_float(random_bits(1, 1, i)), v = to_unit_float(random_bits(1, 2, i));
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto [a, b, c] = mesh.triangles[t];
    return {(1 - u - v) * mesh.vertices[a] + u * mesh.vertices[b] + v * mesh.vertices[c],
            triangle_normal(mesh, t)};
}

// Every point has a sample that is near and faces the same way, on needles as on bumps: no cell is
// far longer than wide.
TEST(ClusterFragments, EveryPointHasASampleNearby) {
    const TriangleMesh meshes[] = {test::needle_mesh(400, 1, 20), test::needle_mesh(12, 1, 20),
                                   test::bumpy_mesh(6), test::bumpy_mesh(3)};
    for (const TriangleMesh& mesh : meshes)
        for (float spacing : {0.8f, 0.3f}) {
            const SurfaceSamples samples = sample_surface(mesh, spacing);
            for (std::uint64_t k = 0; k < 500; ++k) {
                const auto [x, n] = random_point(mesh, k);
                float nearest = kInfinity;
                for (std::size_t i = 0; i < samples.size(); ++i)
                    if (glm::dot(samples.normal[i], n) > 0.5f)
                        nearest = std::min(nearest, glm::distance(samples.position[i], x));
                EXPECT_LT(nearest, 1.8f * spacing) << mesh.triangles.size() << " triangles";
            }
        }
}

// Centroids of clusters lie under a curved surface by h^2 / 8r at most, twice that at the corners
// of a square; light is gathered on it.
TEST(ClusterFragments, StayNearTheSurface) {
    const TriangleMesh mesh = test::sphere_mesh(7, 3);
    for (float spacing : {0.6f, 0.3f}) {
        const SurfaceSamples samples = sample_surface(mesh, spacing);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            EXPECT_LT(3 - glm::length(samples.position[i]), spacing * spacing / 12);
            EXPECT_NEAR(glm::length(samples.ray_origin[i]), 3, 1e-3);
            EXPECT_GT(glm::dot(samples.normal[i], glm::normalize(samples.position[i])), 0.999f);
        }
    }
}

// Noise finer than the spacing turns triangles by more than the angle within which they may join.
// That must not make a sample of each.
TEST(ClusterFragments, NoiseDoesNotMultiplyThem) {
    TriangleMesh rough = test::grid_mesh({0, 0, 0}, {10, 0, 0}, {0, 10, 0}, 200);
    for (std::uint32_t i = 0; i < rough.vertices.size(); ++i)
        rough.vertices[i].z = 0.1f * to_unit_float(random_bits(2, 0, i));
    const double area = surface_area(rough);
    const SurfaceSamples samples = sample_surface(rough, 1);
    EXPECT_NEAR(area_facing(samples, {0, 0, 1}, 180), area, 1e-4 * area);
    EXPECT_LT(double(samples.size()), 8 * area);  // measured: 6.5; there are 80 000 triangles
}

}  // namespace
}  // namespace tallow
