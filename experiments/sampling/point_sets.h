// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/geometry/mesh.h"
#include "precompute/sample_surface.h"

namespace tallow {

/// What others sample surfaces with, to compare with cells. All carry the same area each, in Morton
/// order.

/// Uniform random points.
SurfaceSamples random_points(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed);

/// Blue noise: random points of which none is nearer than a distance to one before it (dart
/// throwing; points that face away from each other do not count), the distance chosen such that
/// about `count` fit.
/// Source   Cook 1986, "Stochastic Sampling in Computer Graphics"; [JB02] use such points.
SurfaceSamples blue_noise(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed);

/// The same points with the areas of their Voronoi cells: each of `fine`'s samples gives its area
/// to the nearest point that faces the same way.
SurfaceSamples with_voronoi_areas(SurfaceSamples points, const SurfaceSamples& fine);

}  // namespace tallow
