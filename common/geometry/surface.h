// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/gtc/matrix_inverse.hpp>
#include <variant>

#include "common/geometry/mesh.h"

namespace tallow {

/// x -> linear * x + translation.
struct Affine {
    glm::mat3 linear{1.0f};
    Vec3 translation{0.0f};

    Vec3 point(Vec3 p) const { return linear * p + translation; }
    Vec3 vector(Vec3 v) const { return linear * v; }
    /// Normals transform with the inverse transpose; unit result.
    Vec3 normal(Vec3 n) const { return glm::normalize(glm::inverseTranspose(linear) * n); }
};

/// The map that applies `inner` first, then `outer`.
Affine compose(const Affine& outer, const Affine& inner);

/// Image of the unit sphere around the origin: a sphere or an ellipsoid. |det| > 0.
struct SphereSurface {
    Affine to_world;
};

/// Image of the unit disc in the plane z = 0, facing +z. Two-sided, encloses nothing.
struct DiscSurface {
    Affine to_world;
};

/// The plane through `point`; the half-space on the side opposite to the unit `normal` is inside.
/// `radius` is infinite, except for a translucent half-space: there light enters only within
/// `radius` of `point`, as through the opening of a black diaphragm.
struct PlaneSurface {
    Vec3 point;
    Vec3 normal;
    float radius = kInfinity;  // mm
};

/// What one object of the scene is, in world space and mm.
using Surface = std::variant<TriangleMesh, SphereSurface, DiscSurface, PlaneSurface>;

/// Texture coordinates of a point of the unit sphere: longitude / 2 pi and latitude / pi, both from
/// 0 to 1, with the pole (v = 1) at +y, the middle of a picture at +z and its borders at -z.
Vec2 sphere_uv(DVec3 p);

/// Of a point of the unit disc: 0 to 1 along its diameters x and y.
Vec2 disc_uv(DVec3 p);

/// Of a point of a plane: mm from its point, along the axes of make_frame(normal); x and -z for a
/// floor, x and y for a wall that faces +z.
Vec2 plane_uv(const PlaneSurface& plane, DVec3 x);

/// The smallest axis-parallel box around something; inside out while it holds nothing.
struct Box {
    Vec3 low{kInfinity}, high{-kInfinity};

    void add(Vec3 p) { low = glm::min(low, p), high = glm::max(high, p); }
};

/// Box around a surface, mm. Of a half-space's opening that of a ball around it; infinite for an
/// unbounded plane.
Box bounding_box(const Surface& surface);

/// The cube [-1/2, 1/2]^3 under `to_world`, twelve triangles, flat. Each face has uvs from 0 to 1,
/// a picture upright on the sides; its upper border lies at -z on the top, at +z on the bottom.
TriangleMesh cube_mesh(const Affine& to_world);

/// `mesh` under `to_world`; a mirroring transform turns the triangles so that they face outward.
TriangleMesh transform_mesh(TriangleMesh mesh, const Affine& to_world);

}  // namespace tallow
