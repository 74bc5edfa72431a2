// SPDX-License-Identifier: Apache-2.0
#include "render/march_steps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/optics/phase.h"
#include "common/optics/single_scattering.h"

namespace tallow {
namespace {

// Relative error of the march with 2^k steps: the worst column of the table at single_scatter().
constexpr double kMarchError[] = {0.60, 0.20, 0.090, 0.040, 0.034, 0.011, 0.0046};
constexpr int kMostSteps = 1024;  // chosen: beyond, light sources have to be sampled better

double march_error(int log2_steps) {
    constexpr int kLast = int(std::size(kMarchError)) - 1;
    if (log2_steps <= kLast) return kMarchError[log2_steps];
    return kMarchError[kLast] * std::exp2(kLast - log2_steps);  // slower than measured before
}

}  // namespace

double single_scattering_share(Model model, const Medium& medium) {
    const double phase =
        std::max(1.0, 4 * std::numbers::pi * double(henyey_greenstein(medium.g, -1)));
    double squares = 0, total = 0;
    for (int c = 0; c < 3; ++c) {
        const double once = std::min(
            1.0,
            phase * single_scattering_reflectance(double(medium.albedo()[c]), double(medium.eta)));
        squares += once * once / 3;
        const auto profile = make_profile(model, medium, c, Orders::two_and_more);
        total += (once + profile->total_reflectance()) / 3;
    }
    return total > 0 ? std::sqrt(squares) / total : 0;
}

int march_steps_of_pixel(Model model, const Medium& medium, double tolerance) {
    const double allowed = std::max(tolerance, 1e-4) / 3;
    const double share = single_scattering_share(model, medium);
    int log2_steps = 0;
    while (1 << log2_steps < kMostSteps && share * march_error(log2_steps) > allowed) ++log2_steps;
    return 1 << log2_steps;
}

}  // namespace tallow
