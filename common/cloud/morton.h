// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.h"
#include "common/cloud/point_octree.h"

namespace tallow {

/// Morton codes of points in the smallest cube that holds them all. `bits` per axis, at most
/// kMortonBits: short codes sort faster. The highest three (x, y, z) pick the octant of the root.
std::vector<std::uint64_t> morton_codes(std::span<const Vec3> points, int bits = kMortonBits);

/// Indices that sort `keys`, fewer than 2^32 of them; equal keys keep their order. The same for any
/// number of threads.
std::vector<std::uint32_t> sorted_order(std::span<const std::uint64_t> keys);

}  // namespace tallow
