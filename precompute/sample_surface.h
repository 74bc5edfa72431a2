// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/vec.h"
#include "common/geometry/surface.h"
#include "precompute/triangle_cells.h"

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

/// Samples a surface with cells of about spacing x spacing, area / spacing^2 of them.
///
/// Meshes: large triangles are cut into cells, small ones clustered with neighbours that face the
/// same way; see triangle_cells.h, cluster_fragments.h. Spheres (and ellipsoids) and the opening of
/// a half-space are cut into bands and rings of cells. The same for any number of threads.
///
/// There are more than area / spacing^2 samples where a body is thinner than the spacing.
///
/// Units    spacing in mm, > 0.
/// Error    the areas sum to the surface's area to rounding (ellipsoids: to 1e-6, by quadrature).
///          Centres are on the surface; centroids of clusters within spacing^2 * curvature of it.
SurfaceSamples sample_surface(const Surface& surface, float spacing);

/// How many samples that makes, without making them. Exact but for meshes with small triangles,
/// of which only a part is clustered.
///
/// Error    1 % (measured: bunny, a sphere of 20M triangles).
double count_samples(const Surface& surface, float spacing);

/// About what sample_surface will have to do, in the time of a look at each triangle.
WorkEstimate estimate_work(const Surface& surface, float spacing);

/// Area in mm^2 of the part of a surface that is sampled. Infinite for an unbounded plane.
double surface_area(const Surface& surface);

}  // namespace tallow
