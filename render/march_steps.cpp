// SPDX-License-Identifier: Apache-2.0
#include "render/march_steps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/optics/phase.h"
#include "common/optics/single_scattering.h"

namespace tallow {
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

MarchNoise march_noise(Connection connection, const Surface& surface, double tolerance) {
    constexpr int kMost = 1024;  // chosen: beyond, lights have to be sampled better
    if (connection == Connection::straight) return {1.25, 0.9, kMost};
    if (std::holds_alternative<TriangleMesh>(surface)) {
        constexpr double kMostAtOnePercent = 128;
        const double most = kMostAtOnePercent * 0.01 / std::max(tolerance, 1e-4);
        return {1.1, 0.55, std::clamp(int(most), 8, kMost)};
    }
    return {2.1, 0.9, kMost};
}

int march_steps_of_pixel(Model model, const Medium& medium, double tolerance, MarchNoise noise) {
    const double allowed = std::max(tolerance, 1e-4);
    const double share = single_scattering_share(model, medium);
    int steps = 1;
    while (steps < noise.most && share * noise.factor * std::pow(steps, -noise.power) > allowed)
        steps *= 2;
    return steps;
}

int march_steps_of_pixel(const SubsurfaceMaterial& material, const Surface& surface,
                         const Settings& settings, double tolerance) {
    return settings.single_scattering_depths
               ? *settings.single_scattering_depths
               : march_steps_of_pixel(material.model, material.medium, tolerance,
                                      march_noise(material.connection, surface, tolerance));
}

}  // namespace tallow
