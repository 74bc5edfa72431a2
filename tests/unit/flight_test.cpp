// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/flight.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tallow {
namespace {

constexpr double kMfp = 0.7;

TEST(Collisions, OfAnEndlessWayDecay) {
    const Flight flight = Flight::straight({0, 0, -1});
    const Collisions collisions(flight, kMfp);
    EXPECT_EQ(collisions.probability(), 1);
    for (const double u : {0.0, 0.1, 0.5, 0.99})
        EXPECT_NEAR(collisions.at(u).z, kMfp * std::log1p(-u), 1e-6);
}

// Light goes 1 mm, a third of it is mirrored and goes 2 mm, half of that 4 mm. A share u of what
// scatters does so in front of at(u).
TEST(Collisions, GoOnBehindMirrors) {
    const Flight flight{
        {Flight::Leg{{1, 0, 0}, 1, 1}, {{0, 1, 0}, 2, 1 / 3.0f}, {{0, 0, 1}, 4, 1 / 6.0f}}};
    const Collisions collisions(flight, kMfp);
    const auto scattered = [](double way) { return -std::expm1(-way / kMfp); };
    const auto left = [](double way) { return std::exp(-way / kMfp); };
    const double first = scattered(1), second = left(1) / 3 * scattered(2),
                 third = left(3) / 6 * scattered(4);
    const double all = first + second + third;
    EXPECT_NEAR(collisions.probability(), all, 1e-6);
    for (const double way : {0.2, 0.9}) {
        const Vec3 x = collisions.at(scattered(way) / all);
        EXPECT_NEAR(x.x, way, 1e-5);
        EXPECT_EQ(x.y, 0);
    }
    const Vec3 on_second = collisions.at((first + left(1) / 3 * scattered(0.5)) / all);
    EXPECT_NEAR(on_second.x, 1, 1e-5);
    EXPECT_NEAR(on_second.y, 0.5, 1e-4);
    const Vec3 on_third = collisions.at((first + second + left(3) / 6 * scattered(1)) / all);
    EXPECT_NEAR(on_third.y, 2, 1e-5);
    EXPECT_NEAR(on_third.z, 1, 1e-3);
}

// The rules are made for e^(kappa t), on ways of any length; kappa near 0 stands for the mean
// depth.
template <std::size_t N>
void expect_exact(const DecayRule<N>& rule, double kappa) {
    for (const double length : {0.3, 1.0, 4.0, 11.0, 1e3}) {
        const double all = -std::expm1(-length);
        double sum = 0, weights = 0;
        for (std::size_t k = 0; k < N; ++k) {
            const double t = -std::log1p(-all * rule.share_on(k, length));
            EXPECT_LE(t, length);
            sum += all * rule.weight[k] * std::exp(kappa * t);
            weights += rule.weight[k];
        }
        const double exact = -std::expm1(-(1 - kappa) * length) / (1 - kappa);
        EXPECT_NEAR(weights, 1, 1e-6);
        EXPECT_NEAR(sum, exact, 2e-3 * exact) << kappa << " " << length;  // measured 1e-3, at 11
    }
}

TEST(DecayRule, IsExactForDecayingLight) {
    for (const double kappa : {0.001, 0.1, 0.4, 0.7}) {
        expect_exact(first_scattering_rule(kappa), kappa);
        expect_exact(last_scattering_rule(kappa), kappa);
    }
}

}  // namespace
}  // namespace tallow
