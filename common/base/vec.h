// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>

namespace tallow {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using DVec3 = glm::dvec3;

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kTwoPi = 2 * kPi;
inline constexpr float kInvPi = 1 / kPi;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Directions are unit; `origin` in mm.
struct Ray {
    Vec3 origin;
    Vec3 direction;
};

/// Right-handed orthonormal basis whose third axis is `n`.
struct Frame {
    Vec3 s, t, n;
    Vec3 to_world(Vec3 local) const { return local.x * s + local.y * t + local.z * n; }
};

/// Source: Duff et al. 2017, "Building an Orthonormal Basis, Revisited". Domain: |n| = 1.
inline Frame make_frame(Vec3 n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1 / (sign + n.z);
    const float b = n.x * n.y * a;
    return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

inline float length2(Vec3 v) { return glm::dot(v, v); }
inline bool is_finite(Vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace tallow
