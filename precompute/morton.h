// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.h"

namespace tallow {

/// Morton codes of points in the smallest cube that holds them all, kMortonBits per axis; the
/// highest three bits (x, y, z) pick the octant of the root.
std::vector<std::uint64_t> morton_codes(std::span<const Vec3> points);

/// Indices that sort `keys`; equal keys keep their order. The same for any number of threads.
std::vector<std::uint32_t> sorted_order(std::span<const std::uint64_t> keys);

}  // namespace tallow
