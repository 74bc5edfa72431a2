// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/diffuse_limit.h"

#include <algorithm>
#include <numbers>

#include "common/optics/quadrature.h"

namespace tallow {

double spilled_share(const Profile& profile, double mean_free_path, double footprint) {
    constexpr double kPiD = std::numbers::pi, kStep = 0.05;
    const double total = profile.total_reflectance();
    if (total == 0) return 0;
    // Outside of `all` everything is spilled: what the integral inside does not account for.
    const double all = kPiD / 4 * footprint;
    const double inner = std::min(1e-5 * mean_free_path, 1e-3 * all);
    const auto light = [&](double r) { return 2 * kPiD * r * profile(r * r); };
    const double inside = integrate_log(inner, all, kStep, light);
    const double spilled =
        integrate_log(inner, all, kStep, [&](double r) { return light(r) * r / all; });
    return std::clamp((spilled + std::max(0.0, total - inside)) / total, 0.0, 1.0);
}

bool is_diffuse_at(const Medium& medium, Model model, float footprint_mm, double tolerance) {
    for (int channel = 0; channel < 3; ++channel) {
        const auto profile = make_profile(model, medium, channel, Orders::all);
        if (spilled_share(*profile, medium.mean_free_path()[channel], footprint_mm) > tolerance)
            return false;
    }
    return true;
}

}  // namespace tallow
