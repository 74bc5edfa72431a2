// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "render/snell.h"

namespace tallow {

/// The point of the plane through `point` with unit `normal` where light from y is refracted to x.
/// There is one, because the optical length is convex along the plane; nothing if x and y are not
/// behind and before it. A monotone equation in the plane of incidence.
std::optional<DVec3> refract_through_plane(const Ends& ends, DVec3 point, DVec3 normal);

/// All points of a sphere where light from y is refracted to x inside. They lie in the plane of the
/// centre, x and y, except where x is on a caustic. Nothing if x is not inside or y not outside.
///
///     f(phi) = eta sin_t - sin_i
///
/// is a sum of two functions of the angle at the centre that are monotone between known points:
/// that excludes intervals without a root and separates the others.
///
/// Error    roots closer together than 1e-4 rad, a caustic, may be missed in pairs.
std::vector<DVec3> refract_through_sphere(const Ends& ends, DVec3 center, double radius);

}  // namespace tallow
