// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/snell.h"

namespace tallow {

/// Where a part of a surface lies and where it faces: a ball and a cone of normals.
struct PatchBound {
    Vec3 center;
    float radius;
    Vec3 axis;       // unit
    float cos_cone;  // of the cone's half angle; not above 0 if normals may have any direction
    float sin_cone;
};

/// Tells parts of a surface that cannot refract light from y to x. Conservative: what it refuses
/// holds no solution; what it lets pass may hold none.
///
/// Over a ball the directions to x and y are cones, hence h = eta w_x + w_y lies in a ball. At a
/// solution |h| = eta cos_t - cos_i is at most sqrt(eta^2 - 1), the value at grazing incidence; -h
/// is along the normal; and the normal has y before and x behind it.
///
/// Parts farther from x than `reach` are refused as well.
///
/// Domain   eta >= 1, reach > 0, may be infinite.
/// Source   the spindle, side and normal tests of [WZHB09] section 5, with balls for boxes.
class RefractionCull {
public:
    explicit RefractionCull(const Ends& ends, float reach = kInfinity)
        : RefractionCull(ends, 0, 0, reach) {}

    /// For all x within `x_radius` and all y within `y_radius` of the ends, directions at infinity
    /// being points of the unit sphere.
    RefractionCull(const Ends& ends, float x_radius, float y_radius, float reach)
        : x_(ends.x),
          y_(ends.y),
          x_radius_(x_radius),
          y_radius_(y_radius),
          reach_(reach),
          y_at_infinity_(ends.y_at_infinity),
          eta_(float(ends.eta)),
          h_max_(float(std::sqrt(std::max(0.0, ends.eta * ends.eta - 1)))) {}

    bool may_refract(const PatchBound& bound) const;

    /// Whether x and y are so far away and normals vary so little over the part that Newton's
    /// method from its middle finds the only solution.
    bool is_small(const PatchBound& bound) const;

    /// Whether the part, seen from close by, is flat enough to have one solution like a plane, and
    /// Newton's method finds it from the plane's.
    static bool is_flat(const PatchBound& bound);

private:
    /// All directions to an end from a ball: a unit axis and the cone's half angle.
    struct Cone {
        Vec3 axis;
        float cosine, sine;
        float chord;  // longest |w - axis|
    };
    Cone cone(Vec3 d, float radius) const;

    Vec3 x_, y_;
    float x_radius_, y_radius_;  // mm
    float reach_;                // mm
    bool y_at_infinity_;
    float eta_, h_max_;
};

}  // namespace tallow
