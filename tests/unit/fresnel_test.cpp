// SPDX-License-Identifier: Apache-2.0
#include "common/optics/fresnel.h"

#include <gtest/gtest.h>

namespace tallow {
namespace {

TEST(Fresnel, KnownValues) {
    EXPECT_NEAR(fresnel_reflectance(1.5, 1.0), 0.04, 1e-15);  // ((eta - 1) / (eta + 1))^2
    EXPECT_NEAR(fresnel_reflectance(1.5, 0.0), 1, 1e-15);
    EXPECT_NEAR(fresnel_reflectance(1.0, 0.3), 0, 1e-30);
    // Brewster's angle, tan = eta: only the perpendicular part is left, ((1-eta^2)/(1+eta^2))^2/2.
    const double cos_brewster = 1 / std::sqrt(1 + 1.5 * 1.5);
    EXPECT_NEAR(fresnel_reflectance(1.5, cos_brewster), 0.5 * std::pow(1.25 / 3.25, 2), 1e-14);
}

TEST(Fresnel, TotalReflectionBeyondTheCriticalAngle) {
    const double eta = 1 / 1.5, mu_critical = std::sqrt(1 - eta * eta);
    EXPECT_EQ(fresnel_reflectance(eta, mu_critical - 1e-9), 1);
    EXPECT_LT(fresnel_reflectance(eta, mu_critical + 1e-3), 1);
}

TEST(Fresnel, TheSameFromBothSides) {
    for (double eta : {0.75, 1.3, 1.5, 3.0})
        for (double mu = 0.05; mu < 1; mu += 0.1) {
            const double sin2_t = (1 - mu * mu) / (eta * eta);
            if (sin2_t >= 1) continue;
            EXPECT_NEAR(fresnel_reflectance(eta, mu),
                        fresnel_reflectance(1 / eta, std::sqrt(1 - sin2_t)), 1e-12);
        }
}

// Walsh 1926, closed form of the mean external reflectance of a dielectric at eta = 1.5: 0.09178.
TEST(Fresnel, MeanTransmittanceIsWalshs) {
    EXPECT_NEAR(1 - diffuse_fresnel_transmittance(1.5), 0.0918, 5e-5);
}

// What enters must be what leaves in equilibrium: (1 - F_dr) eta^2 = mean transmittance.
TEST(Fresnel, MeansOfBothSidesAreReciprocal) {
    for (double eta : {0.75, 1.0001, 1.3, 1.5, 3.0})
        EXPECT_NEAR((1 - diffuse_fresnel_reflectance(eta)) * eta * eta,
                    diffuse_fresnel_transmittance(eta), 1e-9)
            << eta;
}

// The fit printed in [JMLH01] is within 0.0016 for eta 1 to 2, and 0.016 off at 3.
TEST(Fresnel, NearThePublishedFit) {
    const auto fit = [](double eta) {
        return -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
    };
    for (double eta : {1.0, 1.02, 1.05, 1.1, 1.2, 1.3, 1.4, 1.5, 2.0})
        EXPECT_NEAR(diffuse_fresnel_reflectance(eta), fit(eta), 0.00161) << eta;
    EXPECT_NEAR(fit(3) - diffuse_fresnel_reflectance(3), 0.0159, 1e-4);
    EXPECT_NEAR(diffuse_fresnel_reflectance(1.0), 0, 1e-12);
}

TEST(Fresnel, RefractionObeysSnell) {
    const Vec3 n(0, 0, 1);
    for (float eta : {0.75f, 1.0f, 1.5f})
        for (float sine : {0.0f, 0.3f, 0.7f}) {
            const Vec3 w(sine, 0, std::sqrt(1 - sine * sine));
            const auto t = refract(w, n, eta);
            ASSERT_TRUE(t);
            EXPECT_NEAR(t->x, -sine / eta, 1e-6f);
            EXPECT_LT(t->z, 0);
            EXPECT_NEAR(-t->z, refracted_cosine(eta, w.z), 1e-6f);
        }
    EXPECT_FALSE(refract(Vec3(0.9f, 0, std::sqrt(0.19f)), n, 0.75f));
}

}  // namespace
}  // namespace tallow
