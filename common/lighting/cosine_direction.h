// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "common/base/vec.h"

namespace tallow {

/// Unit direction around the unit vector n with the density cos / pi. `u` in [0, 1)^2.
inline Vec3 cosine_direction(const Frame& frame, Vec2 u) {
    const float phi = kTwoPi * u.y, sine = std::sqrt(u.x);
    return glm::normalize(
        frame.to_world({sine * std::cos(phi), sine * std::sin(phi), std::sqrt(1 - u.x)}));
}
inline Vec3 cosine_direction(Vec3 n, Vec2 u) { return cosine_direction(make_frame(n), u); }

}  // namespace tallow
