// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>

#include "common/base/vec.h"

namespace tallow {

/// Unpolarised Fresnel reflectance of a smooth dielectric boundary.
///
/// Domain   eta > 0 is the index on the far side over the index on the near side;
///          0 <= cos_i <= 1 on the near side. 1 at total internal reflection.
/// Source   Fresnel's equations; [JMLH01] section 2.1 uses their unpolarised mean.
template <class F>
F fresnel_reflectance(F eta, F cos_i) {
    const F sin2_t = (1 - cos_i * cos_i) / (eta * eta);
    if (sin2_t >= 1) return 1;
    const F cos_t = std::sqrt(1 - sin2_t);
    const F parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    const F perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    return (parallel * parallel + perpendicular * perpendicular) / 2;
}

inline float fresnel_transmittance(float eta, float cos_i) {
    return 1 - fresnel_reflectance(eta, cos_i);
}

/// Cosine on the far side by Snell's law, or 0 at total internal reflection.
///
///     cos_t = sqrt(1 - (1 - cos_i^2) / eta^2)
inline float refracted_cosine(float eta, float cos_i) {
    return std::sqrt(std::fmax(0.0f, 1 - (1 - cos_i * cos_i) / (eta * eta)));
}

/// Direction of refraction. `w` points away from the surface on the side of `n`; the result points
/// away from the surface on the other side. Nothing at total internal reflection.
inline std::optional<Vec3> refract(Vec3 w, Vec3 n, float eta) {
    const float cos_i = glm::dot(w, n);
    const float cos2_t = 1 - (1 - cos_i * cos_i) / (eta * eta);
    if (cos2_t <= 0) return std::nullopt;
    return glm::normalize((cos_i / eta - std::sqrt(cos2_t)) * n - w / eta);
}

/// Mirror direction; `w` and the result both point away from the surface.
inline Vec3 reflect(Vec3 w, Vec3 n) { return 2 * glm::dot(w, n) * n - w; }

/// Moments of the reflectance seen from the side whose index is 1 / eta of the far side.
///
///     fresnel_moment(eta, k) = integral over mu in [0, 1] of F_r(eta, mu) mu^k
///
/// Error    below 1e-10, by adaptive quadrature split at the critical angle.
double fresnel_moment(double eta, int k);

/// Diffuse Fresnel reflectance F_dr seen from inside: 2 * integral of F_r(1/eta, mu) mu.
/// `eta` is inside / outside as everywhere. Source: [JMLH01] section 2.1, by quadrature; the
/// polynomial printed there is a fit, within 0.0016 of it for eta 1 to 2 and 0.016 off at eta 3.
double diffuse_fresnel_reflectance(double eta);

/// Mean transmittance of cosine-distributed light arriving from outside: 2 * integral of F_t mu.
double diffuse_fresnel_transmittance(double eta);

}  // namespace tallow
