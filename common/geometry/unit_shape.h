// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/geometry/surface.h"

namespace tallow {

/// A sphere or disc under an affine map, ready to be met by rays in the space where it has
/// radius 1. Solved in double: far and small ones lose no digits.
struct UnitShape {
    enum class Kind { sphere, disc } kind;
    Affine to_world;
    glm::dmat3 to_object_linear;
    DVec3 to_object_translation;
};

UnitShape make_unit_shape(UnitShape::Kind kind, const Affine& to_world);

/// Parameters t of the two crossings of the unit sphere, or the crossing of the unit disc twice;
/// nothing if the ray misses. t counts in world lengths because the direction is the transformed
/// world direction, not renormalised.
struct Crossings {
    bool any = false;
    double t[2];
};
Crossings cross(const UnitShape& shape, DVec3 origin, DVec3 direction);

/// First crossing in (near, far], or a negative number.
double first_crossing(const Crossings& crossings, double near, double far);

/// Where a ray is at t, on the unit sphere or disc in its own space.
DVec3 surface_point(const UnitShape& shape, DVec3 origin, DVec3 direction, double t);

Vec3 to_world(const UnitShape& shape, DVec3 p);

/// Unit normal at a point of the surface, world space.
Vec3 surface_normal(const UnitShape& shape, Vec3 position);

/// A little larger than the shape, so that rounding in the ray tracer cannot cut it.
Box bounding_box(const UnitShape& shape);

}  // namespace tallow
