// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/base/rng.h"
#include "common/geometry/position_hash.h"

namespace tallow {

/// Finds points at equal positions: a hash table of indices into `points`, with linear probing,
/// between 6 and 12 bytes a point. `points` may grow, must outlive the table and not change.
class PositionTable {
public:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    /// For at most `capacity` different positions.
    PositionTable(const std::vector<Vec3>& points, std::size_t capacity)
        : points_(points), slots_(std::bit_ceil(capacity + capacity / 2 + 1), kNone) {}

    /// The index entered for the position, or kNone.
    std::uint32_t find(Vec3 position) const { return slots_[slot_of(position)]; }

    /// The same, after entering `index`, whose point need not be in place yet, if there was none.
    std::uint32_t find_or_enter(Vec3 position, std::uint32_t index) {
        std::uint32_t& slot = slots_[slot_of(position)];
        if (slot == kNone) slot = index;
        return slot;
    }

private:
    std::size_t slot_of(Vec3 position) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t slot = mix_bits(PositionHash()(position)) & mask;
        while (slots_[slot] != kNone && points_[slots_[slot]] != position) slot = (slot + 1) & mask;
        return slot;
    }

    const std::vector<Vec3>& points_;
    std::vector<std::uint32_t> slots_;
};

}  // namespace tallow
