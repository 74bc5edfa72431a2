// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/geometry/mesh.h"
#include "common/geometry/mesh_io.h"

namespace tallow {

/// Where triangles of a mesh came from.
struct TriangleOrigin {
    std::vector<std::uint32_t> component;  // [triangle] connected component
    std::vector<bool> turned;              // [component] faces the other way in the file
};

/// Normals for the corners of a mesh, three a triangle, unit, each within 90 degrees of its
/// triangle's: the file's if it has any, found by position; otherwise, and where the file's is
/// missing or faces away, the angle-weighted mean at the vertex; where even that faces away, the
/// triangle's own. Of several normals at one position (a crease) a corner takes the nearest to its
/// triangle's. Normals of a turned component are negated if they were meant for its old side.
///
/// The mean is weighted by the triangles' angles at the vertex: unlike one by area it does not
/// depend on how the surface is cut.
/// Source: Thuermer, Wuethrich 1998, "Computing Vertex Normals from Polygonal Facets".
std::vector<Vec3> smooth_corner_normals(const TriangleMesh& mesh, const TriangleOrigin& origin,
                                        const PolygonSoup& soup);

}  // namespace tallow
