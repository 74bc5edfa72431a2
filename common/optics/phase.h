// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "common/base/vec.h"

namespace tallow {

/// Henyey-Greenstein phase function.
///
///     p = (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^(3/2))
///
/// Units    1/sr; integrates to 1 over the sphere.
/// Domain   -1 < g < 1; cos_theta between the directions of travel before and after.
/// Source   Henyey, Greenstein 1941. The denominator is written as (1 - g)^2 + 2 g (1 - cos), which
///          does not cancel for g near 1 in the forward direction.
inline float henyey_greenstein(float g, float cos_theta) {
    const float base = std::max((1 - g) * (1 - g) + 2 * g * (1 - cos_theta),
                                (1 - std::abs(g)) * (1 - std::abs(g)));
    return (1 - g) * (1 + g) / (4 * kPi * base * std::sqrt(base));
}

}  // namespace tallow
