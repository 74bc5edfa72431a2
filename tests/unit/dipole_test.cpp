// SPDX-License-Identifier: Apache-2.0
#include "common/optics/dipole.h"

#include <gtest/gtest.h>

#include <vector>

namespace tallow {
namespace {

// Marble, skim milk, ketchup (low albedo), spectralon (no absorption); [JMLH01] figure 5.
const std::vector<Medium> kMedia = {
    {{0.0021f, 0.0041f, 0.0071f}, {2.19f, 2.62f, 3.0f}, 0, 1.5f},
    {{0.0014f, 0.0025f, 0.0142f}, {0.7f, 1.22f, 1.9f}, 0, 1.3f},
    {{0.061f, 0.97f, 1.45f}, {0.18f, 0.07f, 0.03f}, 0, 1.3f},
    {{0, 0, 0}, {11.6f, 20.4f, 14.9f}, 0, 1.3f},
};

// Trapezoidal rule in log r; the integrand vanishes at both ends.
template <class F>
double integrate_log(double low, double high, F&& f) {
    const int n = 20000;
    const double step = std::log(high / low) / n;
    double sum = 0;
    for (int i = 0; i <= n; ++i) {
        const double r = low * std::exp(i * step);
        sum += f(r) * r * step * (i == 0 || i == n ? 0.5 : 1.0);
    }
    return sum;
}

// Analytic limit: -z e^(-s d) / d is an antiderivative of r pole(z), which gives the closed form.
TEST(Dipole, PlaneIntegralIsTotalReflectance) {
    for (const Medium& medium : kMedia)
        for (int c = 0; c < 3; ++c) {
            const auto m = dipole_channel<double>(medium, c, mismatch_A(medium.eta));
            const double integral = integrate_log(1e-7, 1e7, [&](double r) {
                return 2 * std::numbers::pi * r * diffuse_reflectance(m, r * r);
            });
            EXPECT_NEAR(integral, total_reflectance(m), 1e-6) << medium.eta << " channel " << c;
        }
}

// The closed form as [JMLH01] section 2.3 prints it, with s = sqrt(3 (1 - alpha')).
TEST(Dipole, TotalReflectanceIsThePapersClosedForm) {
    for (const Medium& medium : kMedia)
        for (int c = 0; c < 3; ++c) {
            const double A = mismatch_A(medium.eta);
            const auto m = dipole_channel<double>(medium, c, A);
            const double s = std::sqrt(3 * (1 - m.alpha_prime));
            const double printed =
                m.alpha_prime / 2 * (1 + std::exp(-4.0 / 3 * A * s)) * std::exp(-s);
            EXPECT_NEAR(total_reflectance(m), printed, 1e-7);
        }
}

TEST(Dipole, WithoutAbsorptionEverythingComesBack) {
    const auto m = dipole_channel<double>(kMedia[3], 0, mismatch_A(1.3));
    EXPECT_DOUBLE_EQ(total_reflectance(m), 1);
}

// The kernel of pass two against the reference, from touching to far: measured 3.2e-6.
TEST(Dipole, FloatAgreesWithDouble) {
    for (const Medium& medium : kMedia)
        for (int c = 0; c < 3; ++c) {
            const auto reference = dipole_channel<double>(medium, c, mismatch_A(medium.eta));
            const auto fast = dipole_channel<float>(medium, c, mismatch_A(medium.eta));
            for (float r2 = 1e-6f; r2 < 1e4f; r2 *= 1.7f) {
                const double expected = diffuse_reflectance(reference, double(r2));
                if (reference.sigma_tr * std::sqrt(r2) > 50) continue;  // below 1e-20 of the peak
                EXPECT_NEAR(diffuse_reflectance(fast, r2), expected, 4e-6 * expected) << r2;
            }
        }
}

TEST(Dipole, FallsMonotonicallyAndIsFiniteAtZero) {
    for (const Medium& medium : kMedia)
        for (int c = 0; c < 3; ++c) {
            const auto m = dipole_channel<double>(medium, c, mismatch_A(medium.eta));
            double previous = diffuse_reflectance(m, 0.0);
            EXPECT_TRUE(std::isfinite(previous));
            for (double r2 = 1e-8; r2 < 1e4; r2 *= 1.3) {
                const double value = diffuse_reflectance(m, r2);
                EXPECT_LE(value, previous);
                previous = value;
            }
        }
}

// Lengths times s and coefficients over s leave reflectances alone; R_d is per area.
TEST(Dipole, ScalesWithTheScene) {
    const Medium& marble = kMedia[0];
    Medium scaled = marble;
    scaled.sigma_a *= 0.001f, scaled.sigma_s_prime *= 0.001f;
    const double A = mismatch_A(marble.eta);
    for (int c = 0; c < 3; ++c) {
        const double small = diffuse_reflectance(dipole_channel<double>(marble, c, A), 2.0);
        const double large = diffuse_reflectance(dipole_channel<double>(scaled, c, A), 2.0e6);
        EXPECT_NEAR(large * 1e6, small, 1e-6 * small);
    }
}

}  // namespace
}  // namespace tallow
