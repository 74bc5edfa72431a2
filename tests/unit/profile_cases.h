// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "common/optics/profile.h"

namespace tallow::test {

/// A grey medium of a given reduced albedo and reduced extinction.
inline Medium grey_medium(double absorption, float sigma_t_prime, float eta) {
    const auto sigma_a = float(absorption * double(sigma_t_prime));
    const auto sigma_s_prime = float((1 - absorption) * double(sigma_t_prime));
    return {Rgb(sigma_a), Rgb(sigma_s_prime), 0, eta};
}

/// Integral over the plane by Gauss-Legendre panels in ln r, in mean free paths: a rule of its own,
/// other than the one the models use.
inline double plane_integral(const Profile& profile, double mean_free_path) {
    constexpr double kNode[3] = {-0.7745966692414834, 0, 0.7745966692414834};
    constexpr double kWeight[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
    const double low = std::log(1e-7), high = std::log(1e8);
    const int panels = 600;
    const double h = (high - low) / panels;
    double sum = 0;
    for (int panel = 0; panel < panels; ++panel)
        for (int i = 0; i < 3; ++i) {
            const double r = std::exp(low + (panel + 0.5 * (1 + kNode[i])) * h) * mean_free_path;
            sum += 0.5 * h * kWeight[i] * 2 * M_PI * r * r * profile(r * r);
        }
    return sum;
}

}  // namespace tallow::test
