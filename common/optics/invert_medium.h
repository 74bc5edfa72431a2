// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "common/optics/profile.h"

namespace tallow {

/// Largest total reflectance that a half-space can have under a model: that without absorption.
double largest_reflectance(Model model, float eta, float g);

/// Share of light that each reduced interaction absorbs, 1 - alpha', in a half-space whose total
/// reflectance (all scattering orders that the model holds) is `reflectance`. Given as the small
/// 1 - alpha' because alpha' itself loses it to rounding in bright media.
///
/// Domain   0 <= reflectance; nothing above largest_reflectance() + 1e-6.
/// Error    below 1e-6 in the reflectance of the returned medium, for all models and 1 <= eta <= 2;
///          by bracketed root finding.
/// Source   Alefeld, Potra, Shi 1995, "Algorithm 748", as Boost.Math has it.
std::optional<double> invert_reflectance(Model model, double reflectance, float eta, float g);

/// Coefficients of one channel from what invert_reflectance() found and a mean free path
/// 1 / sigma_t' in mm.
struct ChannelCoefficients {
    float sigma_a, sigma_s_prime;  // 1/mm
};
ChannelCoefficients channel_coefficients(double absorbed, double mean_free_path);

}  // namespace tallow
