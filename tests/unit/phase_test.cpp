// SPDX-License-Identifier: Apache-2.0
#include "common/optics/phase.h"

#include <gtest/gtest.h>

namespace tallow {
namespace {

// Midpoint rule in the angle, fine enough for |g| up to 0.99: measured 4e-5.
TEST(Phase, IntegratesToOneWithMeanCosineG) {
    for (float g : {-0.9f, -0.3f, 0.0f, 1e-4f, 0.5f, 0.99f}) {
        double total = 0, mean = 0;
        const int n = 200000;
        for (int i = 0; i < n; ++i) {
            const double theta = std::numbers::pi * (i + 0.5) / n;
            const double ring = 2 * std::numbers::pi * std::sin(theta) * std::numbers::pi / n;
            const double p = henyey_greenstein(g, float(std::cos(theta)));
            total += ring * p;
            mean += ring * p * std::cos(theta);
        }
        EXPECT_NEAR(total, 1, 1e-4) << g;
        EXPECT_NEAR(mean, g, 1e-4) << g;
    }
}

TEST(Phase, ForwardPeakDoesNotCancel) {
    // p(g, cos = 1) = (1 + g) / (4 pi (1 - g)^2); 0.9999 as the float that it is.
    const float g = 0.9999f;
    const double exact = (1 + double(g)) / (4 * std::numbers::pi * std::pow(1 - double(g), 2));
    EXPECT_NEAR(henyey_greenstein(g, 1) / exact, 1, 1e-5);
    EXPECT_NEAR(henyey_greenstein(-g, -1) / exact, 1, 1e-3);
}

// The cumulative distribution of henyey_greenstein, integrated from -1, in double.
double cumulative(double g, double cosine) {
    if (std::abs(g) < 1e-5) return (1 + cosine) / 2 * (1 - 1.5 * g * (1 - cosine));
    const double base = (1 - g) * (1 - g) + 2 * g * (1 - cosine);
    return (1 - g * g) / (2 * g) * (1 / std::sqrt(base) - 1 / (1 + g));
}

// Sampling inverts the cumulative distribution, at all g, and stays a cosine.
TEST(Phase, SamplingInvertsTheCumulativeDistribution) {
    for (float g : {-0.9999f, -0.9f, -1e-4f, 0.0f, 1e-7f, 1e-4f, 0.3f, 0.9f, 0.999f, 0.9999f}) {
        float previous = -1;
        for (int i = 0; i <= 1000; ++i) {
            const float u = float(i) / 1000;
            const float cosine = sample_henyey_greenstein(g, u);
            ASSERT_TRUE(cosine >= -1 && cosine <= 1) << g << ' ' << u;
            ASSERT_GE(cosine, previous) << g << ' ' << u;
            previous = cosine;
            // A float cosine near the peak is 6e-8 off, over a peak of width (1 - |g|)^2.
            const double rounding = 1e-7 / std::pow(1 - std::abs(double(g)), 2);
            EXPECT_NEAR(cumulative(g, cosine), u, 1e-6 + rounding) << g << ' ' << u;
        }
    }
}

// Means of stratified samples: g, and the second Legendre moment g^2.
TEST(Phase, SamplesHaveTheMomentsOfThePhaseFunction) {
    for (float g : {-0.9999f, -0.5f, 0.0f, 1e-5f, 0.75f, 0.99f, 0.9999f}) {
        double first = 0, second = 0;
        const int n = 100000;
        for (int i = 0; i < n; ++i) {
            const double cosine = sample_henyey_greenstein(g, (float(i) + 0.5f) / n);
            first += cosine / n, second += (1.5 * cosine * cosine - 0.5) / n;
        }
        EXPECT_NEAR(first, g, 1e-4) << g;
        EXPECT_NEAR(second, g * g, 1e-4) << g;
    }
}

}  // namespace
}  // namespace tallow
