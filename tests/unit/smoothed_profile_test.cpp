// SPDX-License-Identifier: Apache-2.0
// Profiles averaged over the plane, and what follows from how much of them lies nearby.
#include "common/exitance/smoothed_profile.h"

#include <gtest/gtest.h>

#include <numbers>

#include "common/exitance/diffuse_limit.h"
#include "common/exitance/exitance_kernels.h"
#include "tests/support/scenes.h"
#include "tests/unit/profile_cases.h"

namespace tallow {
namespace {

using test::grey_medium;

double smooth_at(const Profile& profile, double r, Smoothing smoothing) {
    // By polar coordinates around r, where g is: no Bessel functions. With d as u^2 the integrand
    // is flat at both ends, and the midpoint rule good to more than its second order.
    constexpr int kRings = 3000, kDirections = 256;
    const double step = std::sqrt(9 * smoothing.sigma) / kRings;
    double sum = 0;
    for (int i = 0; i < kRings; ++i) {
        const double u = (i + 0.5) * step, d = u * u,
                     q = d * d / (2 * smoothing.sigma * smoothing.sigma);
        double ring = 0;
        for (int j = 0; j < kDirections; ++j) {
            const double c = std::cos(std::numbers::pi * (j + 0.5) / kDirections);
            ring += profile(r * r + d * d + 2 * r * d * c) / kDirections;
        }
        sum += 2 * u * step * d * ring * (1 + smoothing.t * (1 - q)) * std::exp(-q);
    }
    return sum / (smoothing.sigma * smoothing.sigma);
}

// Measured 3e-7, of which most is the twin's.
TEST(SmoothedProfile, IsTheAverageOverThePlane) {
    const Medium medium = grey_medium(0.02, 1, 1.4f);
    const auto profile = make_profile(Model::dipole, medium, 0, Orders::all);
    for (const Smoothing smoothing : {Smoothing{0.2}, {0.3, 1}, {1}, {0.7, 0.5}, {8}}) {
        const SmoothedProfile smooth(*profile, 1, smoothing);
        for (const double r : {0.0, 0.1, 0.7, 2.0, 5.0, 9.0}) {
            const double expected = smooth_at(*profile, r, smoothing);
            EXPECT_NEAR(smooth(r * r), expected, 1e-6 * expected)
                << "sigma " << smoothing.sigma << " t " << smoothing.t << " r " << r;
        }
    }
}

// By tables, as the sums use them. Measured 6.4e-7 (transport).
TEST(SmoothedProfile, KeepsThePlaneIntegral) {
    const Medium medium = grey_medium(0.01, 1, 1.4f);
    for (const auto& [name, model] : kModels) {
        const auto profile = make_profile(model, medium, 0, Orders::all);
        for (const double sigma : {0.05, 0.25, 1.0, 7.0, 25.0})
            for (const double t : {0.0, 1.0}) {
                if (t > 0 && sigma > 0.5) continue;
                const SmoothedProfile smooth(*profile, 1, {sigma, t});
                const double scale = std::max(1.0, sigma);
                const KernelTable table = tabulate(smooth, scale, KernelTable::unit_near(scale));
                EXPECT_NEAR(table.total(), profile->total_reflectance(),
                            2e-6 * profile->total_reflectance())
                    << name << " sigma " << sigma << " t " << t;
            }
    }
}

// Sharpened kernels are used as long as they have no rim below 0, at any spacing.
TEST(ExitanceKernels, AreNowhereNegative) {
    for (const auto& [name, model] : kModels)
        for (const double absorption : {1e-4, 0.1})
            for (double h = 0.02; h < 50; h *= 1.8) {
                const ExitanceKernels kernels =
                    make_exitance_kernels(model, grey_medium(absorption, 1, 1.3f), Orders::all, h);
                const KernelTable& K = kernels.profiles[0];
                const double centre = K(0);
                for (double r = 0.01 * h; r * r < K.range(); r *= 1.1)
                    ASSERT_GE(K(float(r * r)), -1e-7 * centre)
                        << name << " absorption " << absorption << " h " << h << " r " << r;
            }
}

// Sums at the default spacing must not cost shadow rays; where it is ten times that, they do.
TEST(ExitanceKernels, NeedIrradianceWhereSamplesAreFarApart) {
    for (const auto& [name, model] : kModels)
        for (const Medium& medium : {test::marble(), test::skim_milk()}) {
            const double mfp = min_channel(medium.mean_free_path());
            for (const Orders orders : {Orders::all, Orders::two_and_more}) {
                const auto needs = [&](double h) {
                    return make_exitance_kernels(model, medium, orders, h * mfp).needs_irradiance();
                };
                EXPECT_FALSE(needs(0.35)) << name;
                EXPECT_TRUE(needs(6)) << name;
            }
        }
}

// beta and kappa are averages of R^ over spatial frequencies with positive weights.
TEST(NearbyParts, GoFromNothingToEverything) {
    for (const auto& [name, model] : kModels) {
        const auto profile = make_profile(model, grey_medium(0.02, 1, 1.4f), 0, Orders::all);
        const double total = profile->total_reflectance();
        double beta = 0;
        for (double sigma = 0.01; sigma < 400; sigma *= 2) {
            const NearbyParts parts = nearby_parts(*profile, 1, sigma);
            EXPECT_GT(parts.beta, beta) << name << " sigma " << sigma;
            EXPECT_GT(parts.kappa, -1e-6) << name << " sigma " << sigma;
            EXPECT_LT(parts.kappa, 1.0001 * total);
            beta = parts.beta;
        }
        EXPECT_LT(nearby_parts(*profile, 1, 0.01).beta, 0.004 * total) << name;  // 0.0029: 1/r
        EXPECT_GT(beta, 0.97 * total) << name;  // 0.988: better-dipole
    }
}

// The share that leaves a square which is lit uniformly, by brute force over the plane.
double spilled_by_overlap(const Profile& profile, double footprint) {
    const double low = std::log(1e-6), high = std::log(1e5);
    constexpr int kRadii = 4000, kDirections = 64;
    double sum = 0, total = 0;
    for (int i = 0; i < kRadii; ++i) {
        const double r = std::exp(low + (i + 0.5) * (high - low) / kRadii);
        double overlap = 0;
        for (int j = 0; j < kDirections; ++j) {
            const double phi = std::numbers::pi / 2 * (j + 0.5) / kDirections;
            overlap += std::max(0.0, 1 - r * std::cos(phi) / footprint) *
                       std::max(0.0, 1 - r * std::sin(phi) / footprint) / kDirections;
        }
        sum += r * r * profile(r * r) * (1 - overlap);
        total += r * r * profile(r * r);
    }
    return sum / total;
}

// Measured: the bound is 1.000 to 1.103 times the share of a uniform square.
TEST(DiffuseLimit, SpilledShareIsABoundAndTight) {
    for (const auto& [name, model] : kModels) {
        const auto profile = make_profile(model, grey_medium(0.02, 1, 1.4f), 0, Orders::all);
        for (const double footprint : {0.1, 1.0, 10.0, 100.0, 1000.0}) {
            const double exact = spilled_by_overlap(*profile, footprint);
            const double bound = spilled_share(*profile, 1, footprint);
            EXPECT_GT(bound, 0.999 * exact) << name << " footprint " << footprint;
            EXPECT_LT(bound, 1.15 * exact + 1e-6) << name << " footprint " << footprint;
        }
    }
}

TEST(DiffuseLimit, HoldsForDenseMediaSeenFromAfar) {
    const auto holds = [](float density, float footprint, double tolerance) {
        Medium medium = test::marble();
        medium.sigma_a = density * medium.sigma_a;
        medium.sigma_s_prime = density * medium.sigma_s_prime;
        return is_diffuse_at(medium, Model::transport, footprint, tolerance);
    };
    EXPECT_FALSE(holds(1, 0.1f, 0.01));
    EXPECT_TRUE(holds(1e4f, 0.1f, 0.01));
    EXPECT_TRUE(holds(1, 1e3f, 0.01));  // the same ratio
    EXPECT_FALSE(holds(1e4f, 0.1f, 1e-5));
    Medium black = test::marble();
    black.sigma_s_prime = Rgb(0);
    EXPECT_TRUE(is_diffuse_at(black, Model::transport, 0.1f, 0.01));
}

}  // namespace
}  // namespace tallow
