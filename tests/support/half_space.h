// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/geometry/ray_scene.h"
#include "common/optics/fresnel.h"
#include "common/optics/medium.h"
#include "common/optics/phase.h"

// Single scattering of parallel light in the half-space y < 0, which has a closed form.
namespace tallow::test {

inline Vec3 up_direction(float cosine, float phi) {
    const float s = std::sqrt(1 - cosine * cosine);
    return {s * std::cos(phi), cosine, s * std::sin(phi)};
}

inline Hit hit_at_origin() { return {1, 0, Vec3(0), Vec3(0, 1, 0), Vec3(0, 1, 0)}; }

/// Radiance for irradiance 1 across the beam, from the volume integral with both rays refracted:
/// L = alpha p(cos) T_i T_o E cos_i / (eta^2 (mu_i' + mu_o')).
inline Rgb half_space_radiance(const Medium& medium, Vec3 to_light, Vec3 w_o) {
    const double eta = medium.eta, cos_i = to_light.y, cos_o = w_o.y;
    const double mu_i = std::sqrt(1 - (1 - cos_i * cos_i) / (eta * eta));
    const double mu_o = std::sqrt(1 - (1 - cos_o * cos_o) / (eta * eta));
    const Vec3 in = *refract(to_light, Vec3(0, 1, 0), medium.eta);
    const Vec3 out = -*refract(w_o, Vec3(0, 1, 0), medium.eta);
    const double p = henyey_greenstein(medium.g, glm::dot(in, out));
    const double T_i = 1 - fresnel_reflectance(eta, cos_i),
                 T_o = 1 - fresnel_reflectance(eta, cos_o);
    return float(p * T_i * T_o * cos_i / (eta * eta * (mu_i + mu_o))) * medium.albedo();
}

}  // namespace tallow::test
