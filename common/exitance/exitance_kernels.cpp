// SPDX-License-Identifier: Apache-2.0
// Which part of a profile its samples cannot resolve, and what is done about it.
#include "common/exitance/exitance_kernels.h"

#include <algorithm>

#include "common/exitance/smoothed_profile.h"

namespace tallow {
namespace {

// How much lower R is in its centre after full smoothing, 1 - (R * g)(0) / R(0), over which
// smoothing comes in. Chosen: below the first, R is so smooth that its plain sum has less noise
// than smoothing would blur (the dipole has 0.1 at 0.35 mean free paths, and 0.1 % noise under
// uniform light; at 1 it has 0.5 and 3 %). Profiles that grow as 1/r or -ln r are always above the
// second.
constexpr double kSmoothFrom = 0.15, kSmoothTo = 0.4;

// Pointlike share beta / R_total over which the control variate comes in. Chosen: it takes shadow
// rays at every shading point, so that it is left out at the default spacing, where all models have
// less than the first (at most 0.11). The edge of a hard shadow is up to half that share wrong
// within one spacing without it.
constexpr double kCorrectFrom = 0.12, kCorrectTo = 0.24;

// Less smoothing than this part of the spacing does nothing.
constexpr double kLeastSmoothing = 0.05;

double smooth_step(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

// The part of `sigma` that a profile is to be smoothed with.
double smoothing(const Profile& profile, double mean_free_path, double sigma) {
    const double centre = SmoothedProfile(profile, mean_free_path, sigma)(0) / profile(0);
    return smooth_step(kSmoothFrom, kSmoothTo, 1 - centre);
}

}  // namespace

ExitanceKernels make_exitance_kernels(Model model, const Medium& medium, Orders orders,
                                      double spacing_mm) {
    const Rgb scale = medium.mean_free_path();
    const double full = kSmoothing * spacing_mm;
    std::array<std::unique_ptr<Profile>, 3> profiles;
    std::array<double, 3> scales{}, sigmas{}, beta{}, kappa{};
    for (int channel = 0; channel < 3; ++channel) {
        const auto c = std::size_t(channel);
        profiles[c] = make_profile(model, medium, channel, orders);
        scales[c] = scale[channel];
        if (profiles[c]->total_reflectance() == 0) continue;
        const NearbyParts parts = nearby_parts(*profiles[c], scales[c], full);
        const double used =
            smooth_step(kCorrectFrom, kCorrectTo, parts.beta / profiles[c]->total_reflectance());
        beta[c] = used * parts.beta;
        kappa[c] = used * parts.kappa;
        sigmas[c] = full * smoothing(*profiles[c], scales[c], full);
        if (sigmas[c] < kLeastSmoothing * spacing_mm) continue;
        profiles[c] = std::make_unique<SmoothedProfile>(*profiles[c], scales[c], sigmas[c]);
        scales[c] = std::max(scales[c], sigmas[c]);
    }
    const double unit = KernelTable::unit_near((scales[0] + scales[1] + scales[2]) / 3);
    const auto table = [&](std::size_t c) { return tabulate(*profiles[c], scales[c], unit); };
    return {{table(0), table(1), table(2)}, beta, kappa, full};
}

std::array<KernelTable, 3> tabulate_profiles(Model model, const Medium& medium, Orders orders) {
    const Rgb scale = medium.mean_free_path();
    const double unit = KernelTable::unit_near(mean(scale));
    const auto table = [&](int channel) {
        return tabulate(*make_profile(model, medium, channel, orders), scale[channel], unit);
    };
    return {table(0), table(1), table(2)};
}

}  // namespace tallow
