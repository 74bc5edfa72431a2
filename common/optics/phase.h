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

/// Cosine of the angle between the directions of travel before and after, distributed as
/// henyey_greenstein, for `u` uniform in [0, 1]: the exact inverse of the cumulative distribution.
///
///     cos = 1 - (1 - u) (1 - g)^2 (2 + 2 g u) / (1 - g + 2 g u)^2       for g >= 0
///
/// Domain   |g| <= 0.9999; the result lies in [-1, 1] and grows with u.
/// Error    that of rounding the result, 6e-8, at every g.
/// Source   Witt 1977, "Multiple scattering in reflection nebulae I", multiplied out so that
/// nothing
///          is divided by g: the usual form cancels for small g, and loses the forward peak for g
///          near 1. A negative g mirrors the positive one.
inline float sample_henyey_greenstein(float g, float u) {
    const double a = std::abs(g);
    const double v = g < 0 ? 1 - double(u) : double(u);
    const double q = (1 - a) / (1 - a + 2 * a * v);
    const auto cosine = static_cast<float>(1 - 2 * (1 - v) * q * q * (1 + a * v));
    return g < 0 ? -cosine : cosine;
}

}  // namespace tallow
