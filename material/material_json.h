// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "material/describe_material.h"

namespace tallow {

/// JSON object with the keys sigma_a, sigma_s_prime, g, eta, alpha_prime, sigma_tr,
/// mean_free_path_mm, F_dr, A, z_r_mm, z_v_mm, and models: {NAME: {total_reflectance: [r, g, b],
/// profile: [[r_mm, R, G, B], ...]}}. Numbers have the digits (up to 17) that give the same double
/// back when they are read.
std::string material_json(const MaterialReport& report);

}  // namespace tallow
