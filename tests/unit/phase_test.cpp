// SPDX-License-Identifier: Apache-2.0
#include "common/optics/phase.h"

#include <gtest/gtest.h>

namespace tallow {
namespace {

// Midpoint rule in the angle, fine enough for |g| up to 0.99: measured 2e-5.
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

}  // namespace
}  // namespace tallow
