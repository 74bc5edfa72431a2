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

TEST(LeavingRays, FitLinearRadiance) {
    const Vec3 n = glm::normalize(Vec3(1, -2, 0.5f)), slope(0.3f, -0.2f, 0.9f);
    const LeavingRays rays(n);
    std::array<float, LeavingRays::kDirections> X{};
    for (std::size_t d = 0; d < X.size(); ++d) {
        const Vec3 w = rays.direction(d);
        EXPECT_NEAR(glm::length(w), 1, 1e-5);
        EXPECT_GE(glm::dot(w, n), 0.79f);
        X[d] = 2 + glm::dot(slope, w);
    }
    const LeavingRadiance fit = rays.fit(X);
    EXPECT_NEAR(fit.even, 2, 1e-4);
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(fit.slope[axis], slope[axis], 1e-4);
}

}  // namespace
}  // namespace tallow
