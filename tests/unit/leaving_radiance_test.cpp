// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/leaving_radiance.h"

#include <gtest/gtest.h>

namespace tallow {
namespace {

// Linear functions decay without error: the integral over z of (a + b z) e^(-z/m) / m is a + b m,
// if the last node lies so deep that what is behind it does not count.
TEST(DecayWeights, AreExactForLinearFunctions) {
    const std::array nodes = {0.1, 0.5, 2.0, 40.0};
    for (const double m : {0.5, 1.0, 1.7}) {
        const auto weights = decay_weights(nodes, m);
        double one = 0, z = 0;
        for (std::size_t k = 0; k < nodes.size(); ++k)
            one += weights[k], z += weights[k] * nodes[k];
        EXPECT_NEAR(one, 1, 1e-12);
        EXPECT_NEAR(z, m, 1e-9);
    }
}

// A fluence that is constant along each way, and depends on the way as a linear function does.
TEST(LeavingRays, FitLinearRadiance) {
    const Vec3 x(1, 2, 3), n = glm::normalize(Vec3(1, -2, 0.5f)), slope(0.3f, -0.2f, 0.9f);
    const LeavingRays rays(x, n, 0.5);
    std::array<std::array<double, LeavingRays::kNodes>, LeavingRays::kDirections> fluence{};
    for (std::size_t d = 0; d < fluence.size(); ++d)
        for (std::size_t k = 0; k < LeavingRays::kNodes; ++k) {
            const Vec3 way = glm::normalize(x - rays.place(d, k));
            EXPECT_GE(glm::dot(way, n), 0.79f);
            fluence[d][k] = double(2 + glm::dot(slope, way));
        }
    const LeavingRadiance F = rays.fit(fluence);
    EXPECT_NEAR(F.even, 2, 1e-4);
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(F.slope[axis], slope[axis], 1e-4);
}

TEST(LeavingRays, AreFollowedInMeanFreePaths) {
    const Vec3 x(0, 0, 0), n(0, 0, 1);
    const LeavingRays near(x, n, 1), far(x, n, 3);
    for (std::size_t d = 0; d < LeavingRays::kDirections; ++d)
        for (std::size_t k = 0; k < LeavingRays::kNodes; ++k) {
            EXPECT_LT(near.place(d, k).z, 0);
            EXPECT_NEAR(glm::length(far.place(d, k)), 3 * glm::length(near.place(d, k)), 1e-5);
        }
}

}  // namespace
}  // namespace tallow
