// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "common/base/vec.h"

namespace tallow {

/// Hash of exact positions for unordered containers: equal vectors, equal hashes.
struct PositionHash {
    std::size_t operator()(Vec3 p) const {
        p += Vec3(0.0f);  // -0 == 0, but their bits differ
        std::size_t hash = std::bit_cast<std::uint32_t>(p.x);
        hash = hash * 0x9e3779b97f4a7c15ull + std::bit_cast<std::uint32_t>(p.y);
        hash = hash * 0x9e3779b97f4a7c15ull + std::bit_cast<std::uint32_t>(p.z);
        return hash ^ (hash >> 32);
    }
};

}  // namespace tallow
