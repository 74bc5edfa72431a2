// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/base/rgb.h"

namespace tallow {

/// Optical coefficients of a homogeneous translucent medium and its derived quantities.
///
///     sigma_s  = sigma_s' / (1 - g)       sigma_t' = sigma_s' + sigma_a
///     alpha'   = sigma_s' / sigma_t'      sigma_tr = sqrt(3 sigma_a sigma_t')
///
/// Units    coefficients 1/mm, mean free path mm, the rest 1.
/// Domain   sigma_a >= 0, sigma_s' >= 0, sigma_t' > 0 in each channel, -1 < g < 1,
///          eta = inside / outside > 0.
/// Source   [JMLH01] section 2.
struct Medium {
    Rgb sigma_a;
    Rgb sigma_s_prime;
    float g = 0;    ///< mean cosine of the phase function
    float eta = 1;  ///< refractive index inside / outside

    Rgb sigma_s() const { return sigma_s_prime / (1 - g); }
    Rgb sigma_t() const { return sigma_s() + sigma_a; }
    Rgb sigma_t_prime() const { return sigma_s_prime + sigma_a; }
    Rgb alpha_prime() const { return sigma_s_prime / sigma_t_prime(); }
    Rgb albedo() const { return sigma_s() / sigma_t(); }
    Rgb sigma_tr() const {
        return map(3 * sigma_a * sigma_t_prime(), [](float x) { return std::sqrt(x); });
    }
    /// 1 / sigma_t', the reduced mean free path, in mm.
    Rgb mean_free_path() const { return Rgb(1) / sigma_t_prime(); }
};

}  // namespace tallow
