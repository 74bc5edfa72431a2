// SPDX-License-Identifier: Apache-2.0
#include "precompute/morton.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <utility>

#include "common/base/parallel.h"
#include "common/cloud/point_octree.h"

namespace tallow {
namespace {

// Spreads the low 21 bits of x so that two zero bits follow each.
std::uint64_t spread_bits(std::uint64_t x) {
    x &= 0x1fffff;
    x = (x | x << 32) & 0x001f00000000ffffull;
    x = (x | x << 16) & 0x001f0000ff0000ffull;
    x = (x | x << 8) & 0x100f00f00f00f00full;
    x = (x | x << 4) & 0x10c30c30c30c30c3ull;
    x = (x | x << 2) & 0x1249249249249249ull;
    return x;
}

}  // namespace

std::vector<std::uint64_t> morton_codes(std::span<const Vec3> points) {
    Vec3 low(kInfinity), high(-kInfinity);
    for (Vec3 p : points) low = glm::min(low, p), high = glm::max(high, p);
    const Vec3 extent = high - low;
    const double side = std::max({extent.x, extent.y, extent.z, 1e-30f});
    constexpr std::uint64_t kCells = 1ull << kMortonBits;

    std::vector<std::uint64_t> codes(points.size());
    parallel_for(points.size(), 4096, [&](std::size_t i) {
        std::uint64_t code = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double x = (double(points[i][axis]) - low[axis]) / side;
            const auto cell = std::min(kCells - 1, std::uint64_t(x * double(kCells)));
            code |= spread_bits(cell) << (2 - axis);
        }
        codes[i] = code;
    });
    return codes;
}

std::vector<std::uint32_t> sorted_order(std::span<const std::uint64_t> keys) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> pairs(keys.size());
    for (std::size_t i = 0; i < keys.size(); ++i) pairs[i] = {keys[i], std::uint32_t(i)};
    tbb::parallel_sort(pairs.begin(), pairs.end());  // all pairs differ: one possible result
    std::vector<std::uint32_t> order(keys.size());
    for (std::size_t i = 0; i < keys.size(); ++i) order[i] = pairs[i].second;
    return order;
}

}  // namespace tallow
