// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "common/base/vec.h"

namespace tallow {

/// Point k of n that are spread evenly over the unit disc, as seeds in a sunflower are.
inline Vec2 sunflower_point(int k, int n) {
    constexpr float kGoldenAngle = 2.39996323f;
    const float r = std::sqrt((float(k) + 0.5f) / float(n)), angle = kGoldenAngle * float(k);
    return {r * std::cos(angle), r * std::sin(angle)};
}

}  // namespace tallow
