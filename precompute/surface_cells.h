// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/geometry/surface.h"

namespace tallow {

/// A small piece of a surface: the raw material of samples.
struct Cell {
    Vec3 center;  // centroid, on the surface or within rounding of it
    Vec3 normal;  // shading normal at the centre
    float area;   // exact, mm^2
};

/// A number in [0, 1) for each index. Rounding down x_i + dither(i) for consecutive i makes sums
/// of integers that stay within a few units of the sums of x_i: the multiples of the golden ratio,
/// modulo 1, fill the interval evenly.
inline double dither(std::uint64_t index) {
    return double((index * 0x9e3779b97f4a7c15ull) >> 11) * 0x1p-53;
}

/// Latitude bands of the unit sphere cut into cells of nearly equal size and carried to the world;
/// area / spacing^2 of them.
std::vector<Cell> sphere_cells(const SphereSurface& sphere, float spacing);

/// Rings of the disc through which light enters a half-space; area / spacing^2 cells.
/// plane.radius must be finite.
std::vector<Cell> plane_cells(const PlaneSurface& plane, float spacing);

/// How many cells there would be.
double count_sphere_cells(const SphereSurface& sphere, float spacing);
double count_plane_cells(const PlaneSurface& plane, float spacing);

}  // namespace tallow
