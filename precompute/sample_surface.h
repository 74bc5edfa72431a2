// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/vec.h"
#include "common/geometry/surface.h"

namespace tallow {

/// A quadrature of a surface: each sample stands for a cell whose exact area it carries, so that
/// the integral of f over the surface is the sum of f(position) * area. In Morton order.
struct SurfaceSamples {
    std::vector<Vec3> position;    // [sample] centroid of the cell, mm
    std::vector<Vec3> normal;      // [sample] mean shading normal of the cell, unit, outward
    std::vector<float> area;       // [sample] exact area of the cell, mm^2
    std::vector<Vec3> ray_origin;  // [sample] the point of the cell where light is gathered; it is
                                   // on the surface, where a centroid may lie under it

    std::size_t size() const { return position.size(); }
};

/// Samples a surface with cells of about spacing x spacing.
///
/// Meshes: triangles longer than the spacing are bisected at their longest edge, pieces smaller
/// than a quarter of a cell are clustered with their neighbours of similar normal. Spheres (and
/// ellipsoids) and the opening of a half-space are cut into bands and rings of cells.
///
/// Units    spacing in mm, > 0.
/// Error    the areas sum to the surface's area to rounding (ellipsoids: to 1e-6, by quadrature).
SurfaceSamples sample_surface(const Surface& surface, float spacing);

/// Area in mm^2 of the part of a surface that is sampled. Infinite for an unbounded plane.
double surface_area(const Surface& surface);

}  // namespace tallow
