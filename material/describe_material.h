// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "common/optics/profile.h"

namespace tallow {

using Triple = std::array<double, 3>;  // red, green, blue

/// What one model makes of a medium.
struct ModelReport {
    std::string name;
    Triple total_reflectance;     // 1, all scattering orders that the model holds
    std::vector<Triple> profile;  // [radius] 1/mm^2
};

/// Everything that follows from the coefficients of a medium, in double. See Medium and
/// dipole_channel() for the formulas.
struct MaterialReport {
    Triple sigma_a, sigma_s_prime, sigma_s, sigma_t, sigma_t_prime, sigma_tr;  // 1/mm
    Triple alpha_prime, albedo;
    Triple mean_free_path_mm, z_r_mm, z_v_mm;
    double g, eta, F_dr, A;
    std::vector<double> radii_mm;
    std::vector<ModelReport> models;  // in the order of kModels
};

/// Radii in mm must be >= 0.
MaterialReport describe_material(const Medium& medium, std::span<const double> radii_mm);

/// 0.1 to 20 mean free paths in a 1-2-5 sequence, of the channels' geometric mean; in mm, rounded
/// to three digits.
std::vector<double> default_radii(const Medium& medium);

}  // namespace tallow
