// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/base/vec.h"

namespace tallow {

/// The two ends of a path that is refracted once: x inside the body, y outside.
struct Ends {
    DVec3 x;  // mm
    DVec3 y;  // mm; of a light at infinity the unit direction towards it
    bool y_at_infinity;
    double eta;  // inside / outside
};

/// A surface p(u, v) with unit normals n(u, v), to first order around one point. The normals need
/// not be perpendicular to the surface: a mesh may be shaded smoothly.
struct Patch {
    DVec3 p, n;
    DVec3 dp[2], dn[2];  // derivatives by u and v
};

/// How far a path x - p - y is from obeying Snell's law, and how that changes with p.
///
///     h = eta w_x + w_y,   f_k = h . (dp_k - (dp_k . n) n)
///
/// with the unit directions from p to x and to y: f = 0 where h is along n, which is Snell's law.
/// Source   [WZHB09] section 4.1; in their half vector the sign is turned.
struct SnellError {
    glm::dvec2 f;
    glm::dmat2 df;  // df[parameter][component]
    double off;     // length of the tangential part of h: sin_i - eta sin_t in the plane case
};
SnellError snell_error(const Ends& ends, const Patch& patch);

/// Whether x lies on the inner and y on the outer side of the patch's normal.
bool on_both_sides(const Ends& ends, const Patch& patch, DVec3 normal);

/// How densely light from y arrives around x through a patch where snell_error() is zero: solid
/// angle at y, or for a light at infinity area across the beam outside, over area across the beam
/// at x.
///
///     d(u, v) / dx = -(df / d(u, v))^-1 df / dx         (implicit function theorem)
///     |dOmega_y / dA_x| = |det d(u, v) / dx| |(dp_0 x dp_1) . w_y| / |y - p|^2
///
/// Units    1/mm^2, or 1 for a light at infinity.
/// Domain   infinite on a caustic, where df is singular.
/// Source   what [WZHB09] section 4.3 gets from ray differentials.
double spread(const Ends& ends, const Patch& patch);

}  // namespace tallow
