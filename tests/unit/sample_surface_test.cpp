// SPDX-License-Identifier: Apache-2.0
#include "precompute/sample_surface.h"

#include <gtest/gtest.h>

#include <numeric>

#include "common/base/parallel.h"
#include "tests/support/ball_mesh.h"
#include "tests/support/patch_meshes.h"

namespace tallow {
namespace {

double total_area(const SurfaceSamples& samples) {
    return std::accumulate(samples.area.begin(), samples.area.end(), 0.0);
}

TriangleMesh cube(float side) { return cube_mesh({glm::mat3(side), Vec3(1, 2, 3)}); }

// Large triangles: cells of h^2, so that N is area / h^2 where that is at least one for each of the
// twelve triangles.
TEST(SampleSurface, CubeIsCutIntoCellsOfItsExactArea) {
    for (float spacing : {10.0f, 1.0f, 0.13f}) {
        const SurfaceSamples samples = sample_surface(cube(4), spacing);
        EXPECT_NEAR(total_area(samples), 96, 96e-6);
        const double wished = 96.0 / (spacing * spacing);
        EXPECT_NEAR(double(samples.size()), std::max(6.0, wished), 6);
        for (float area : samples.area)
            EXPECT_LE(area, 2 * std::max(wished / 6, 1.0) * spacing * spacing);
    }
}

// Much finer than the spacing: the number of samples follows the spacing, not the triangles.
TEST(SampleSurface, TinyTrianglesAreClustered) {
    const TriangleMesh fine = test::grid_mesh({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 100);
    const SurfaceSamples samples = sample_surface(fine, 0.1f);
    EXPECT_NEAR(total_area(samples), 1, 1e-5);
    EXPECT_NEAR(double(samples.size()), 100, 5);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        EXPECT_NEAR(samples.normal[i].z, 1, 1e-6f);
        EXPECT_LT(glm::length(samples.ray_origin[i] - samples.position[i]), 0.02f);
    }
}

// The two faces of a sheet thinner than the spacing must not be merged.
TEST(SampleSurface, FacesOfAThinSheetStayApart) {
    const glm::mat3 sheet(10.0f, 0, 0, 0, 0.01f, 0, 0, 0, 10.0f);
    const SurfaceSamples samples = sample_surface(cube_mesh({sheet, Vec3(0)}), 1);
    double up = 0, down = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (samples.normal[i].y > 0.9f) up += samples.area[i];
        if (samples.normal[i].y < -0.9f) down += samples.area[i];
    }
    EXPECT_NEAR(up, 100, 1e-4);
    EXPECT_NEAR(down, 100, 1e-4);
}

TEST(SampleSurface, SphereAreaAndPlacement) {
    const SphereSurface sphere{{glm::mat3(3.0f), Vec3(5, 0, 0)}};
    const SurfaceSamples samples = sample_surface(sphere, 0.2f);
    const double area = 4 * std::numbers::pi * 9;
    EXPECT_NEAR(total_area(samples), area, 1e-6 * area);
    EXPECT_NEAR(surface_area(sphere), area, 1e-6 * area);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        EXPECT_NEAR(glm::length(samples.position[i] - Vec3(5, 0, 0)), 3, 1e-5f);
        EXPECT_NEAR(glm::dot(samples.normal[i], (samples.position[i] - Vec3(5, 0, 0)) / 3.0f), 1,
                    1e-5f);
        EXPECT_LE(samples.area[i], 1.1f * 0.2f * 0.2f);
    }
}

// Prolate spheroid, semi-axes 1, 1, 2: 2 pi (1 + 2 / e asin e), e = sqrt(3) / 2.
TEST(SampleSurface, EllipsoidArea) {
    const glm::mat3 stretch(1, 0, 0, 0, 1, 0, 0, 0, 2);
    const double e = std::sqrt(3.0) / 2;
    const double area = 2 * std::numbers::pi * (1 + 2 / e * std::asin(e));
    const SphereSurface spheroid{{stretch, Vec3(0)}};
    EXPECT_NEAR(total_area(sample_surface(spheroid, 0.1f)), area, 1e-5 * area);
    EXPECT_NEAR(surface_area(spheroid), area, 1e-5 * area);
}

TEST(SampleSurface, OpeningOfAHalfSpace) {
    const PlaneSurface plane{{1, 2, 3}, glm::normalize(Vec3(1, 1, 0)), 7};
    const SurfaceSamples samples = sample_surface(plane, 0.3f);
    const double area = std::numbers::pi * 49;
    EXPECT_NEAR(total_area(samples), area, 1e-6 * area);
    for (Vec3 p : samples.position) {
        EXPECT_LT(glm::length(p - plane.point), 7);
        EXPECT_NEAR(glm::dot(p - plane.point, plane.normal), 0, 1e-5f);
    }
}

// A midpoint rule: halving the spacing quarters the error. Integral of x^2 + y^2 over the square.
TEST(SampleSurface, QuadratureConvergesWithTheSquareOfTheSpacing) {
    TriangleMesh square;
    square.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    square.triangles = {{0, 1, 2}, {0, 2, 3}};
    const auto error = [&](float spacing) {
        const SurfaceSamples samples = sample_surface(square, spacing);
        double sum = 0;
        for (std::size_t i = 0; i < samples.size(); ++i)
            sum += double(samples.area[i]) * double(length2(samples.position[i]));
        return std::abs(sum - 2.0 / 3);
    };
    const double coarse = error(0.2f), fine = error(0.05f);
    EXPECT_LT(coarse, 0.2f * 0.2f);
    EXPECT_LT(fine, coarse / 8);
}

// Cells stand at their centroids, so that linear functions are integrated exactly, however small or
// large the triangles are: over the square |x - 3|, |y - 2| < 1, turned by 0.4.
TEST(SampleSurface, LinearFunctionsAreIntegratedExactly) {
    const Vec3 u(2 * std::cos(0.4f), 2 * std::sin(0.4f), 0), v(-u.y, u.x, 0);
    const Vec3 center(3, 2, 1);
    for (std::uint32_t n : {1u, 2u, 7u, 40u, 200u}) {
        const TriangleMesh square = test::grid_mesh(center - 0.5f * (u + v), u, v, n);
        for (float spacing : {1.0f, 0.3f, 0.07f, 0.021f}) {
            const SurfaceSamples samples = sample_surface(square, spacing);
            DVec3 moment(0);
            for (std::size_t i = 0; i < samples.size(); ++i)
                moment += double(samples.area[i]) * DVec3(samples.position[i]);
            // Measured: 2.8e-6, rounding of positions to floats.
            EXPECT_LT(glm::distance(moment, 4.0 * DVec3(center)), 4e-6) << n << ", " << spacing;
        }
    }
}

// Integral of x^2 over the sphere of radius 3: 4 pi 81 / 3. Its bands, and meshes so fine that all
// samples are clusters.
TEST(SampleSurface, SecondMomentsOfASphereConvergeWithTheSquareOfTheSpacing) {
    const auto error = [](const Surface& surface, float spacing, double exact) {
        const SurfaceSamples samples = sample_surface(surface, spacing);
        double sum = 0;
        for (std::size_t i = 0; i < samples.size(); ++i)
            sum += double(samples.area[i]) * double(samples.position[i].x * samples.position[i].x);
        return std::abs(sum / exact - 1);
    };
    const SphereSurface sphere{{glm::mat3(3.0f), Vec3(0)}};
    const double exact = 4 * std::numbers::pi * 81 / 3;
    EXPECT_LT(error(sphere, 0.4f, exact), 2e-3);       // measured: 1.4e-3
    EXPECT_LT(error(sphere, 0.1f, exact), 2e-3 / 12);  // measured: 9.3e-5

    const TriangleMesh fine = test::sphere_mesh(7, 3);  // 131 072 triangles, 0.03 long
    EXPECT_LT(error(fine, 0.4f, exact), 4.5e-3);        // measured: 3.5e-3
    EXPECT_LT(error(fine, 0.2f, exact), 4.5e-3 / 3);    // measured: 9.7e-4
}

TEST(SampleSurface, SameForAnyNumberOfThreads) {
    const auto sampled = [](const Surface& surface, float spacing, int threads) {
        const ThreadLimit limit(threads);
        return sample_surface(surface, spacing);
    };
    // Cells only, clusters only, needles; a sphere's bands; one triangle cut by several threads.
    const Surface surfaces[] = {cube(4), test::bumpy_mesh(6), test::needle_mesh(50, 1, 20),
                                SphereSurface{{glm::mat3(3.0f), Vec3(0)}}};
    for (const Surface& surface : surfaces)
        for (float spacing : {0.5f, 0.03f}) {
            const SurfaceSamples one = sampled(surface, spacing, 1);
            const SurfaceSamples four = sampled(surface, spacing, 4);
            EXPECT_EQ(one.position, four.position);
            EXPECT_EQ(one.normal, four.normal);
            EXPECT_EQ(one.area, four.area);
            EXPECT_EQ(one.ray_origin, four.ray_origin);
        }
}

TEST(SampleSurface, SmoothNormalsAreInterpolated) {
    TriangleMesh triangle;
    triangle.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.triangles = {{0, 1, 2}};
    const Vec3 leaning = glm::normalize(Vec3(1, 0, 1));
    triangle.corner_normals = {{0, 0, 1}, leaning, {0, 0, 1}};
    const SurfaceSamples samples = sample_surface(triangle, 0.1f);
    float least = 1, most = 0;
    for (Vec3 n : samples.normal) {
        EXPECT_NEAR(glm::length(n), 1, 1e-5f);
        least = std::min(least, n.x), most = std::max(most, n.x);
    }
    EXPECT_LT(least, 0.05f);
    EXPECT_GT(most, 0.6f);
}

}  // namespace
}  // namespace tallow
