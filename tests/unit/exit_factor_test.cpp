// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/exit_factor.h"

#include <gtest/gtest.h>

namespace tallow {
namespace {

// 2 * integral of T mu dmu: the part of the exitance that leaves.
float energy(const SurfaceFactors& factors) {
    constexpr int kSteps = 4000;
    float sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const float mu = (float(i) + 0.5f) / kSteps;
        sum += 2 * mu / kSteps * exit_factor(factors, mu);
    }
    return sum;
}

SubsurfaceMaterial material(Exit exit, float eta) {
    SubsurfaceMaterial material;
    material.medium = {Rgb(0.1f), Rgb(1), 0, eta};
    material.exit = exit;
    return material;
}

TEST(ExitFactor, KeepsEnergyUnlessItIsThePapers) {
    for (const float eta : {1.0f, 1.3f, 1.5f, 2.4f})
        for (const Exit exit : {Exit::normalized, Exit::directional})
            EXPECT_NEAR(energy(surface_factors(material(exit, eta))), 1, 1e-4) << eta;
    EXPECT_LT(energy(surface_factors(material(Exit::classic, 1.5f))), 0.95f);
}

}  // namespace
}  // namespace tallow
