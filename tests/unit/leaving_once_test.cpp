// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/leaving_once.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/optics/fresnel.h"
#include "tests/support/point_clouds.h"

namespace tallow {
namespace {

constexpr double kEta = 1.4;

// Mean free path 0.5 mm, albedo 0.9.
ReducedChannel medium() { return reduced_channel({Rgb(0.2f), Rgb(1.8f), 0, float(kEta)}, 0); }

SumTree tree_of(const std::vector<Vec3>& positions, float weight) {
    const test::WeightedCloud cloud =
        test::sorted_cloud(positions, std::vector<float>(positions.size(), weight));
    return {cloud.positions, cloud.weights, cloud.nodes, 0.5};
}

double at(const LeavingOnce& once, Vec3 place, Vec3 normal) {
    OnceSources near;
    return once.at({place, normal}, near).all;
}

// A sheet of sources 1 W/mm^2 at a depth z beneath the plane z = 0, every `spacing` mm.
SumTree sheet(double depth, double spacing) {
    std::vector<Vec3> positions;
    const int n = int(6 / spacing);
    for (int i = -n; i <= n; ++i)
        for (int k = -n; k <= n; ++k) positions.emplace_back(i * spacing, k * spacing, -depth);
    return tree_of(positions, float(spacing * spacing));
}

// alpha' / 2 times the integral of T(mu) e^(-z / mu).
double exitance_of_sheet(const ReducedChannel& reduced, double depth) {
    constexpr int kSteps = 20000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double mu = (i + 0.5) / kSteps;
        sum += double(fresnel_transmittance(float(1 / kEta), float(mu))) *
               std::exp(-depth * reduced.sigma_t_prime / mu) / kSteps;
    }
    return reduced.alpha_prime / 2 * sum;
}

// From far beneath to so near that sources are much farther apart than deep: above a source, and
// where they are not too near for it in the mean of places between them. A lattice in line with
// the place is the worst there is: where the critical angle cuts off a row of it is up to 12 % off.
TEST(LeavingOnce, SheetsMatchTheirClosedForm) {
    const ReducedChannel reduced = medium();
    const double spacing = 0.15;
    for (const double depth : {0.02, 0.1, 0.3, 1.0}) {
        const SumTree tree = sheet(depth, spacing);
        const LeavingOnce once(reduced, tree, spacing * spacing);
        const double expected = exitance_of_sheet(reduced, depth);
        EXPECT_NEAR(at(once, {0, 0, 0}, {0, 0, 1}), expected, 0.12 * expected) << depth;
        if (depth < 0.2) continue;
        double mean = 0;
        for (int i = 0; i < 5; ++i)
            for (int k = 0; k < 5; ++k)
                mean += at(once, Vec3(i * spacing / 5, k * spacing / 5, 0), {0, 0, 1}) / 25;
        EXPECT_NEAR(mean, expected, 0.04 * expected) << depth;
    }
}

// Far from a ball of many sources, where nodes act for them. Measured 0.013 and, where little of
// the light is left, 0.037.
TEST(LeavingOnce, ManySourcesActAsOne) {
    const ReducedChannel reduced = medium();
    test::Draw draw(1);
    std::vector<Vec3> positions;
    for (int i = 0; i < 4000; ++i) positions.push_back(Vec3(0.2 * draw.in_box()));
    const SumTree tree = tree_of(positions, 1 / 4000.0f);
    const LeavingOnce once(reduced, tree, 1e-4);
    for (const double distance : {1.0, 2.0}) {
        double expected = 0;
        for (const Vec3& p : positions) {
            const Vec3 way = Vec3(0, 0, float(distance)) - p;
            const double d = double(glm::length(way)), mu = double(way.z) / d;
            expected += reduced.alpha_prime / (4 * std::numbers::pi) / 4000 *
                        std::exp(-d * reduced.sigma_t_prime) / (d * d) * mu *
                        double(fresnel_transmittance(float(1 / kEta), float(mu)));
        }
        EXPECT_NEAR(at(once, {0, 0, float(distance)}, {0, 0, 1}), expected, 0.05 * expected);
    }
}

// Parts of the light, from where nodes act for many sources to where discs do.
TEST(LeavingOnce, PartsAddUpToTheWhole) {
    const ReducedChannel reduced = medium();
    test::Draw draw(2);
    std::vector<Vec3> positions;
    for (int i = 0; i < 3000; ++i)
        positions.push_back(Vec3(draw.in_box()) * Vec3(1, 1, 0.1f) - Vec3(0, 0, 0.15f));
    const float weight = 1 / 1024.0f;
    const SumTree tree = tree_of(positions, weight);
    std::vector<float> third(positions.size()), others(positions.size());
    for (std::size_t i = 0; i < third.size(); ++i) (i % 3 == 0 ? third : others)[i] = weight;
    const LeavingOnce once(reduced, tree, 1e-3, third), rest(reduced, tree, 1e-3, others);
    OnceSources near;
    for (const Vec3 place : {Vec3(0), Vec3(0.5f, 0.3f, 0), Vec3(0.2f, 0, 1.5f)}) {
        const LeavingOnce::Exitance a = once.at({place, {0, 0, 1}}, near),
                                    b = rest.at({place, {0, 0, 1}}, near);
        EXPECT_EQ(a.all, b.all);
        EXPECT_NEAR(a.part + b.part, a.all, 1e-5 * a.all);
        EXPECT_NEAR(a.part / a.all, 1 / 3.0, 0.15);
    }
}

TEST(LeavingOnce, NothingLeavesBeyondTheCriticalAngle) {
    const SumTree tree = tree_of({Vec3(0)}, 1);
    const LeavingOnce once(medium(), tree, 1e-4);
    EXPECT_GT(at(once, {0, 0, 1}, {0, 0, 1}), 0);
    EXPECT_EQ(at(once, {1.2f, 0, 1}, {0, 0, 1}), 0);  // the critical tangent is 1.02
    EXPECT_EQ(at(once, {0, 0, 1}, {0, 0, -1}), 0);    // from outside
}

// Beyond the body's reach lies a hollow. Towards the place the reach is 0.3 mm, aslant it is more.
TEST(LeavingOnce, NothingComesAcrossHollows) {
    const SumTree tree = tree_of({Vec3(0)}, 1);
    const LeavingOnce once(medium(), tree, 1e-4);
    OnceSources near;
    const LeavingRadiance reach{1.3f, {0, 0, -1}};
    EXPECT_EQ(once.at({{0, 0, 0.6f}, {0, 0, 1}, reach}, near).all, 0);
    EXPECT_EQ(once.at({{0, 0, 0.45f}, {0, 0, 1}, reach}, near).all,
              at(once, {0, 0, 0.45f}, {0, 0, 1}));
    const Vec3 aslant(0.5f, 0, 0.6f);  // where the reach is 0.53 mm
    EXPECT_EQ(once.at({aslant, {0, 0, 1}, reach}, near).all, at(once, aslant, {0, 0, 1}));
}

TEST(LeavingOnce, OfNoSources) {
    const SumTree tree = tree_of({}, 1);
    EXPECT_EQ(at(LeavingOnce(medium(), tree, 1), Vec3(0), {0, 0, 1}), 0);
}

}  // namespace
}  // namespace tallow
