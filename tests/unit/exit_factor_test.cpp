// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/exit_factor.h"

#include <gtest/gtest.h>

namespace tallow {
namespace {

// 2 * integral of T mu dmu: the part of the exitance that leaves.
Rgb energy(const SurfaceFactors& factors) {
    constexpr int kSteps = 4000;
    Rgb sum;
    for (int i = 0; i < kSteps; ++i) {
        const float mu = (float(i) + 0.5f) / kSteps;
        sum += 2 * mu / kSteps * exit_factor(factors, mu);
    }
    return sum;
}

// Albedos of 0.999, 0.98 and 0.5: diffusion, between, none.
SubsurfaceMaterial material(Exit exit, float eta) {
    SubsurfaceMaterial material;
    material.medium = {{0.001f, 0.02f, 1}, {0.999f, 0.98f, 1}, 0, eta};
    material.exit = exit;
    return material;
}

TEST(ExitFactor, KeepsEnergyUnlessItIsThePapers) {
    for (const float eta : {1.0f, 1.3f, 1.5f, 2.4f})
        for (const Exit exit : {Exit::normalized, Exit::directional}) {
            const Rgb whole = energy(surface_factors(material(exit, eta)));
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(whole[c], 1, 1e-4) << eta << " " << c;
        }
    EXPECT_LT(energy(surface_factors(material(Exit::classic, 1.5f)))[0], 0.95f);
}

TEST(ExitFactor, DirectionalLeansToTheNormalWhereLightDiffuses) {
    const SurfaceFactors even = surface_factors(material(Exit::normalized, 1.3f)),
                         leaning = surface_factors(material(Exit::directional, 1.3f));
    for (const float mu : {0.1f, 1.0f}) {
        const Rgb ratio = exit_factor(leaning, mu) / exit_factor(even, mu);
        EXPECT_EQ(ratio[0] > 1, mu == 1) << mu;
        EXPECT_FLOAT_EQ(ratio[2], 1) << mu;
    }
}

}  // namespace
}  // namespace tallow
