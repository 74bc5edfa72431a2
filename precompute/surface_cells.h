// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/geometry/surface.h"

namespace tallow {

/// A small piece of a surface: the raw material of samples.
struct Cell {
    Vec3 center;  // centroid, on the surface or within rounding of it
    Vec3 normal;  // shading normal at the centre
    float area;   // exact, mm^2
};

/// Triangles cut at their longest edge until no edge is longer than about the spacing. Small
/// triangles come out whole. In the order of the mesh's triangles.
std::vector<Cell> mesh_cells(const TriangleMesh& mesh, float spacing);

/// Latitude bands of the unit sphere cut into cells of nearly equal size and carried to the world.
std::vector<Cell> sphere_cells(const SphereSurface& sphere, float spacing);

/// Rings of the disc through which light enters a half-space. plane.radius must be finite.
std::vector<Cell> plane_cells(const PlaneSurface& plane, float spacing);

}  // namespace tallow
