// SPDX-License-Identifier: Apache-2.0
// Octree, scalar sums and the exitance field on clouds made in the test.
#include <gtest/gtest.h>

#include <numeric>

#include "common/base/rng.h"
#include "common/cloud/morton.h"
#include "common/exitance/exitance_field.h"
#include "common/exitance/lit_samples.h"
#include "common/optics/dipole.h"
#include "precompute/build_octree.h"
#include "precompute/sample_surface.h"
#include "tests/support/scenes.h"

namespace tallow {
namespace {

float random_float(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
    return to_unit_float(random_bits(seed, stream, index));
}

/// A body in memory: clustered points on a bumpy shell, one light group, a third of it dark.
struct Cloud {
    std::vector<Vec3> positions, normals, directions;
    std::vector<float> areas;
    std::vector<Rgb> E_t;
    std::vector<OctreeNode> nodes;

    BodyView view() const {
        const double area = std::accumulate(areas.begin(), areas.end(), 0.0);
        return {0, 0.1f, area, positions, normals, areas, nodes, {{E_t, directions}}};
    }
};

Cloud random_cloud(std::uint64_t seed, std::size_t n) {
    Cloud cloud;
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < n; ++i) {
        const float z = 2 * random_float(seed, 0, i) - 1, phi = kTwoPi * random_float(seed, 1, i);
        const float s = std::sqrt(1 - z * z), r = 5 + std::sin(5 * phi) * z;
        points.push_back(r * Vec3(s * std::cos(phi), s * std::sin(phi), z * z * z));
    }
    for (std::size_t i = 0; i + 4 < n; i += 50) points[i + 3] = points[i];  // coincident ones
    for (std::uint32_t i : sorted_order(morton_codes(points))) cloud.positions.push_back(points[i]);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3 direction = -glm::normalize(cloud.positions[i] + Vec3(0, 0, 1e-3f));
        const bool lit = cloud.positions[i].x > -1.5f;
        cloud.normals.push_back(-direction);
        cloud.directions.push_back(lit ? direction : Vec3(0));
        cloud.areas.push_back(0.01f + 0.05f * random_float(seed, 2, i));
        cloud.E_t.push_back(lit ? Rgb(random_float(seed, 3, i), 1, 0.2f) : Rgb(0));
    }
    cloud.nodes = build_octree(cloud.positions);
    return cloud;
}

const std::vector<LightGroup> kOneGroup = {{"default", Rgb(1)}};

// A node stands for the points below it, so it must carry exactly their flux, at their centroid.
TEST(SolidAngleSum, EveryNodeCarriesTheFluxOfItsPoints) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Cloud cloud = random_cloud(seed, 1000);
        std::vector<float> flux;
        for (std::size_t i = 0; i < cloud.areas.size(); ++i)
            flux.push_back(cloud.E_t[i].r * cloud.areas[i]);
        const SolidAngleSum sum(cloud.positions, flux, cloud.areas, cloud.nodes);
        for (const SolidAngleSum::Node& node : sum.nodes()) {
            double weight = 0, area = 0;
            DVec3 moment(0);
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                weight += flux[i];
                area += cloud.areas[i];
                moment += double(flux[i]) * DVec3(cloud.positions[i]);
                EXPECT_LE(length2(cloud.positions[i] - node.centroid), node.radius2);
            }
            ASSERT_NEAR(node.weight, weight, 1e-6 * weight) << "seed " << seed;
            ASSERT_NEAR(node.area, area, 1e-6 * area);
            if (weight > 0) {
                ASSERT_LT(glm::length(moment / weight - DVec3(node.centroid)), 1e-5);
            }
        }
    }
}

TEST(LitSamples, DropDarkSamplesAndKeepTheTreeWhole) {
    const Cloud cloud = random_cloud(3, 4000);
    const LitSamples lit = light_samples(cloud.view(), kOneGroup);
    std::size_t expected = 0;
    for (Rgb E : cloud.E_t) expected += E != Rgb(0);
    ASSERT_EQ(lit.position.size(), expected);
    ASSERT_LT(expected, cloud.positions.size());
    EXPECT_EQ(lit.nodes[0].count, expected);
    EXPECT_EQ(lit.nodes[0].skip, lit.nodes.size());
    for (std::size_t i = 0; i < lit.nodes.size(); ++i) {
        EXPECT_GT(lit.nodes[i].count, 0u);
        std::uint32_t below = 0, children = 0;
        for (std::size_t c = i + 1; c < i + lit.nodes[i].skip; c += lit.nodes[c].skip, ++children)
            below += lit.nodes[c].count;
        if (children > 0) {
            EXPECT_EQ(below, lit.nodes[i].count);
            EXPECT_GE(children, 2u);
        }
    }
}

TEST(LitSamples, GroupScalesAddUp) {
    Cloud cloud = random_cloud(4, 200);
    BodyView view = cloud.view();
    view.groups.push_back(view.groups[0]);
    const std::vector<LightGroup> groups = {{"a", {2, 0, 1}}, {"b", {1, 3, 0}}};
    const LitSamples lit = light_samples(view, groups);
    std::size_t k = 0;
    for (std::size_t i = 0; i < cloud.E_t.size(); ++i) {
        if (cloud.E_t[i] == Rgb(0)) continue;
        const Rgb expected = Rgb(3, 3, 1) * cloud.E_t[i];
        EXPECT_NEAR(lit.E_t[k].r, expected.r, 1e-6f);
        EXPECT_NEAR(lit.E_t[k].g, expected.g, 1e-6f);
        EXPECT_NEAR(lit.E_t[k].b, expected.b, 1e-6f);
        EXPECT_LT(glm::length(lit.w_i[k] - cloud.directions[i]), 1e-5f);
        ++k;
    }
    EXPECT_EQ(k, lit.E_t.size());
    EXPECT_TRUE(light_samples(view, std::vector<LightGroup>{{"a", Rgb(0)}, {"b", Rgb(0)}})
                    .position.empty());
}

ExitanceField field_of(const LitSamples& lit, const Medium& medium, float tolerance) {
    return {lit, tabulate_profiles(Model::dipole, medium, Orders::all),
            ExitanceAccuracy{tolerance}};
}

Rgb direct_double_loop(const Cloud& cloud, const Medium& medium, Vec3 x) {
    Rgb M;
    for (int c = 0; c < 3; ++c) {
        const auto profile = dipole_channel<double>(medium, c, mismatch_A(medium.eta));
        double sum = 0;
        for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
            const DVec3 d = DVec3(x) - DVec3(cloud.positions[i]);
            sum += double(cloud.E_t[i][c]) * double(cloud.areas[i]) *
                   diffuse_reflectance(profile, glm::dot(d, d));
        }
        M[c] = float(sum);
    }
    return M;
}

std::vector<ExitancePoint> points_of(const Cloud& cloud, std::size_t step) {
    std::vector<ExitancePoint> points;
    for (std::size_t i = 0; i < cloud.positions.size(); i += step)
        points.push_back({cloud.positions[i] + Vec3(0.01f), cloud.normals[i], cloud.normals[i]});
    return points;
}

std::vector<Rgb> gather(const ExitanceField& field, std::span<const ExitancePoint> points) {
    return field.gather(points).M;
}

// Measured 1e-7; the tabulated kernel allows 2e-5.
TEST(Exitance, ToleranceZeroIsTheDirectDoubleLoop) {
    const Cloud cloud = random_cloud(1, 3000);
    for (const Medium& medium : {test::marble(), test::skim_milk()}) {
        const ExitanceField field = field_of(light_samples(cloud.view(), kOneGroup), medium, 0);
        const auto points = points_of(cloud, 100);
        const auto M = gather(field, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Rgb expected = direct_double_loop(cloud, medium, points[i].position);
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(M[i][c], expected[c], 2.1e-5 * expected[c]);
        }
    }
}

TEST(Exitance, HierarchyStaysWithinItsTolerance) {
    const Cloud cloud = random_cloud(2, 20000);
    const auto points = points_of(cloud, 40);
    const LitSamples lit = light_samples(cloud.view(), kOneGroup);
    for (const Medium& medium : {test::marble(), test::skim_milk()}) {
        const auto exact = gather(field_of(lit, medium, 0), points);
        for (float tolerance : {0.1f, 0.01f, 0.001f}) {
            const auto M = gather(field_of(lit, medium, tolerance), points);
            double error2 = 0, mean = 0;
            for (std::size_t i = 0; i < points.size(); ++i)
                for (int c = 0; c < 3; ++c) {
                    error2 += std::pow(double(M[i][c]) - exact[i][c], 2);
                    mean += exact[i][c];
                }
            const double count = 3.0 * double(points.size());
            EXPECT_LT(std::sqrt(error2 / count) / (mean / count), tolerance);
        }
    }
}

TEST(Exitance, SwappingChannelsSwapsTheResult) {
    Cloud cloud = random_cloud(5, 1000);
    Medium medium = test::marble();
    const auto points = points_of(cloud, 100);
    const auto M = gather(field_of(light_samples(cloud.view(), kOneGroup), medium, 0.01f), points);
    for (Rgb& E : cloud.E_t) std::swap(E.r, E.b);
    std::swap(medium.sigma_a.r, medium.sigma_a.b);
    std::swap(medium.sigma_s_prime.r, medium.sigma_s_prime.b);
    const auto swapped =
        gather(field_of(light_samples(cloud.view(), kOneGroup), medium, 0.01f), points);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_EQ(M[i], Rgb(swapped[i].b, swapped[i].g, swapped[i].r));
}

TEST(Exitance, NoSamplesGiveNoLight) {
    const ExitanceField field = field_of(LitSamples{}, test::marble(), 0.01f);
    const std::vector<ExitancePoint> point = {{Vec3(0), Vec3(0, 1, 0), Vec3(0, 1, 0)}};
    EXPECT_EQ(gather(field, point)[0], Rgb(0));
}

// A sphere under uniform light: the same exitance everywhere, and equal to the integral of R_d over
// the sphere, chord 2 R sin(theta / 2), by quadrature in theta. Measured 1.6e-5.
TEST(Exitance, SphereUnderUniformLight) {
    const float radius = 4;
    const SphereSurface sphere{{glm::mat3(radius), Vec3(0)}};
    const SurfaceSamples samples = sample_surface(sphere, 0.06f);
    LitSamples lit{samples.position, std::vector<Rgb>(samples.size(), Rgb(1)),
                   std::vector<Vec3>(samples.size(), Vec3(0)), samples.area,
                   build_octree(samples.position)};
    const Medium medium = test::marble();
    const ExitanceField field = field_of(lit, medium, 0);
    std::vector<ExitancePoint> points;
    for (std::uint64_t i = 0; i < 24; ++i) {
        const Vec3 n = glm::normalize(
            Vec3(random_float(1, 0, i), random_float(1, 1, i), random_float(1, 2, i)) - Vec3(0.5f));
        points.push_back({radius * n, n, n});
    }
    const auto M = gather(field, points);
    for (int c = 0; c < 3; ++c) {
        const auto profile = dipole_channel<double>(medium, c, mismatch_A(medium.eta));
        double integral = 0;
        const int n = 200000;
        for (int i = 0; i < n; ++i) {
            const double theta = std::numbers::pi * (i + 0.5) / n;
            const double chord = 2 * double(radius) * std::sin(theta / 2);
            integral += diffuse_reflectance(profile, chord * chord) * 2 * std::numbers::pi *
                        double(radius) * double(radius) * std::sin(theta) * std::numbers::pi / n;
        }
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_NEAR(M[i][c], integral, 1e-4 * integral);
    }
}

}  // namespace
}  // namespace tallow
