// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/unit_shape.h"

#include <cmath>

namespace tallow {

UnitShape make_unit_shape(UnitShape::Kind kind, const Affine& to_world) {
    const glm::dmat3 inverse = glm::inverse(glm::dmat3(to_world.linear));
    return {kind, to_world, inverse, -(inverse * DVec3(to_world.translation))};
}

Crossings cross(const UnitShape& shape, DVec3 origin, DVec3 direction) {
    const DVec3 o = shape.to_object_linear * origin + shape.to_object_translation;
    const DVec3 d = shape.to_object_linear * direction;
    if (shape.kind == UnitShape::Kind::disc) {
        if (d.z == 0) return {};
        const double t = -o.z / d.z;
        const double x = o.x + t * d.x, y = o.y + t * d.y;
        return {x * x + y * y <= 1, {t, t}};
    }
    // Distance of the centre to the line first: no cancellation for far and small spheres.
    const double dd = glm::dot(d, d);
    const double t_middle = -glm::dot(o, d) / dd;
    const DVec3 nearest = o + t_middle * d;
    const double h2 = 1 - glm::dot(nearest, nearest);
    if (h2 < 0) return {};
    const double half = std::sqrt(h2 / dd);
    return {true, {t_middle - half, t_middle + half}};
}

// Of the unit sphere or disc, in its own space.
DVec3 surface_point(const UnitShape& shape, DVec3 origin, DVec3 direction, double t) {
    const DVec3 p = shape.to_object_linear * (origin + t * direction) + shape.to_object_translation;
    return shape.kind == UnitShape::Kind::sphere ? glm::normalize(p) : DVec3(p.x, p.y, 0);
}

Vec3 to_world(const UnitShape& shape, DVec3 p) {
    return Vec3(glm::dmat3(shape.to_world.linear) * p + DVec3(shape.to_world.translation));
}

Vec3 surface_normal(const UnitShape& shape, Vec3 position) {
    if (shape.kind == UnitShape::Kind::disc) return shape.to_world.normal(Vec3(0, 0, 1));
    const DVec3 p = shape.to_object_linear * DVec3(position) + shape.to_object_translation;
    return shape.to_world.normal(Vec3(glm::normalize(p)));
}

// First crossing in (near, far], or a negative number.
double first_crossing(const Crossings& crossings, double near, double far) {
    if (crossings.any)
        for (double t : crossings.t)
            if (t > near && t <= far) return t;
    return -1;
}

Box bounding_box(const UnitShape& shape) {
    const Surface surface = shape.kind == UnitShape::Kind::disc
                                ? Surface(DiscSurface{shape.to_world})
                                : Surface(SphereSurface{shape.to_world});
    Box box = bounding_box(surface);
    const Vec3 pad =
        1e-5f * (0.5f * (box.high - box.low) + glm::abs(shape.to_world.translation)) + Vec3(1e-30f);
    box.low -= pad, box.high += pad;
    return box;
}

}  // namespace tallow
