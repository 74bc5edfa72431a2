// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/vec.h"

namespace tallow {

using Triangle = std::array<std::uint32_t, 3>;  // vertex indices, counter-clockwise from outside

/// A triangle mesh in world space, as the renderer sees it: indices in range, finite vertices, no
/// triangle of zero area. A closed mesh bounds a volume and its triangles face outward.
///
/// corner_normals is empty (flat shading) or holds three unit normals a triangle; corner_uvs is
/// empty or holds three texture coordinates a triangle.
struct TriangleMesh {
    std::vector<Vec3> vertices;  // mm
    std::vector<Triangle> triangles;
    std::vector<Vec3> corner_normals;  // [3 * triangle + corner]
    std::vector<Vec2> corner_uvs{};    // [3 * triangle + corner]
};

/// Unit normal of triangle t, outward. Computed in double: slivers keep their direction.
Vec3 triangle_normal(const TriangleMesh& mesh, std::size_t t);

/// Area of triangle t in mm^2.
double triangle_area(const TriangleMesh& mesh, std::size_t t);

}  // namespace tallow
