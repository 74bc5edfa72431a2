// SPDX-License-Identifier: Apache-2.0
#include "precompute/sample_surface.h"

#include <gtest/gtest.h>

#include <numeric>

#include "common/base/rng.h"

namespace tallow {
namespace {

double total_area(const SurfaceSamples& samples) {
    return std::accumulate(samples.area.begin(), samples.area.end(), 0.0);
}

TriangleMesh cube(float side) { return cube_mesh({glm::mat3(side), Vec3(1, 2, 3)}); }

// Large triangles: cells of about h^2, so that N is about area / h^2.
TEST(SampleSurface, CubeIsCutIntoCellsOfItsExactArea) {
    for (float spacing : {10.0f, 1.0f, 0.13f}) {
        const SurfaceSamples samples = sample_surface(cube(4), spacing);
        EXPECT_NEAR(total_area(samples), 96, 96e-6);
        for (float area : samples.area) EXPECT_LE(area, 1.42f * spacing * spacing);
        if (spacing < 2) {
            const double wished = 96 / (spacing * spacing);
            EXPECT_GT(double(samples.size()), 0.7 * wished);
            EXPECT_LT(double(samples.size()), 1.42 * wished);
        }
    }
}

// Much finer than the spacing: the number of samples follows the spacing, not the triangles.
TEST(SampleSurface, TinyTrianglesAreClustered) {
    TriangleMesh fine;  // a 100 x 100 grid on the unit square
    const std::uint32_t n = 100;
    for (std::uint32_t j = 0; j <= n; ++j)
        for (std::uint32_t i = 0; i <= n; ++i) fine.vertices.push_back({i / 100.0f, j / 100.0f, 0});
    for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t v = j * (n + 1) + i;
            fine.triangles.push_back({v, v + 1, v + n + 2});
            fine.triangles.push_back({v, v + n + 2, v + n + 1});
        }
    const SurfaceSamples samples = sample_surface(fine, 0.1f);
    EXPECT_NEAR(total_area(samples), 1, 1e-5);
    EXPECT_GE(samples.size(), 80u);
    EXPECT_LE(samples.size(), 150u);
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
