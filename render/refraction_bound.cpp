// SPDX-License-Identifier: Apache-2.0
// Cones of directions against cones of normals, without trigonometric functions.
#include "render/refraction_bound.h"

#include <algorithm>
#include <cmath>

namespace tallow {
namespace {

// Rounding of the dot products below is some 1e-6; chosen ten times that. Doubled: a few more
// triangles are tried.
constexpr float kSlack = 1e-5f;

// Angles in which a part counts as small, as sines. Chosen: no solution is lost on the bumpy meshes
// of the tests.
constexpr float kSmall = 0.25f;

// Sine of the normal cone of a part that counts as flat. Chosen: from x within four radii of the
// part directions turn by more than 0.25 over it, so that a tenth of that in normals cannot undo
// it.
constexpr float kFlat = 0.1f;

// Whether some normal of the bound makes less than a right angle with some direction of the cone.
bool may_face(const PatchBound& bound, Vec3 axis, float cosine, float sine) {
    if (bound.cos_cone * cosine - bound.sin_cone * sine <= 0) return true;
    return glm::dot(bound.axis, axis) >=
           -(bound.sin_cone * cosine + bound.cos_cone * sine) - kSlack;
}

}  // namespace

RefractionCull::Cone RefractionCull::cone(Vec3 d, float radius) const {
    const float distance = glm::length(d);
    if (radius >= distance) return {Vec3(0), -1, 0, 2};  // the ball holds the end
    const float sine = radius / distance;
    const float cosine = std::sqrt((1 - sine) * (1 + sine));
    return {d / distance, cosine, sine, sine * std::sqrt(2 / (1 + cosine))};
}

bool RefractionCull::may_refract(const PatchBound& bound) const {
    const float farthest = reach_ + bound.radius + x_radius_;
    if (length2(x_ - bound.center) > farthest * farthest) return false;
    const Cone to_x = cone(x_ - bound.center, bound.radius + x_radius_);
    const Cone to_y =
        y_at_infinity_ ? cone(y_, y_radius_) : cone(y_ - bound.center, bound.radius + y_radius_);
    const bool normals = bound.cos_cone > 0;
    if (normals && to_y.cosine >= 0 && !may_face(bound, to_y.axis, to_y.cosine, to_y.sine))
        return false;
    if (to_x.cosine < 0) return true;
    if (normals && !may_face(bound, -to_x.axis, to_x.cosine, to_x.sine)) return false;
    if (to_y.cosine < 0) return true;

    const Vec3 h = eta_ * to_x.axis + to_y.axis;
    const float length = glm::length(h), reach = eta_ * to_x.chord + to_y.chord;
    if (length - reach > h_max_ + kSlack) return false;
    if (!normals || reach >= length) return true;
    const float sine = reach / length;
    const float cosine = std::sqrt((1 - sine) * (1 + sine));
    return -glm::dot(bound.axis, h) >=
           (bound.cos_cone * cosine - bound.sin_cone * sine - kSlack) * length - kSlack;
}

bool RefractionCull::is_small(const PatchBound& bound) const {
    const float reach = bound.radius / kSmall;
    return bound.cos_cone > 0 && bound.sin_cone < kSmall &&
           length2(x_ - bound.center) > reach * reach &&
           (y_at_infinity_ || length2(y_ - bound.center) > reach * reach);
}

bool RefractionCull::is_flat(const PatchBound& bound) {
    return bound.cos_cone > 0 && bound.sin_cone < kFlat;
}

}  // namespace tallow
