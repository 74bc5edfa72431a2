// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "common/base/vec.h"

namespace tallow::reference {

/// A density on the unit square, constant in each of 32 x 32 cells: which starts are worth more.
class StartMap {
public:
    static constexpr int kSide = 32;
    using Cells = std::array<double, std::size_t(kSide) * kSide>;

    StartMap();  ///< uniform
    /// Density in proportion to `worth`, smoothed over neighbours and nowhere below a tenth of its
    /// mean, because what is known of it is noisy.
    explicit StartMap(const Cells& worth);

    struct Drawn {
        Vec2 u;
        float density;
    };
    /// Warps a uniform point so that it follows the density; keeps stratification.
    Drawn draw(Vec2 u) const;

    static std::size_t cell(Vec2 u) {
        return std::size_t(u.y * kSide) * kSide + std::size_t(u.x * kSide);
    }

private:
    Cells density_;                                             // mean 1
    std::array<double, kSide + 1> rows_;                        // up to a row, normalised
    std::array<std::array<double, kSide + 1>, kSide> columns_;  // [row] up to a column
};

}  // namespace tallow::reference
