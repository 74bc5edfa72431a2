// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "common/base/vec.h"
#include "common/geometry/surface.h"

namespace tallow::reference {

/// Cubic cells over a box.
struct Cells {
    Vec3 low;
    float size;    // mm
    int count[3];  // along x, y, z

    /// About `wanted` cells over `box`, which they cover with a margin of half a cell.
    Cells(const Box& box, double wanted);

    std::size_t total() const {
        return std::size_t(count[0]) * std::size_t(count[1]) * std::size_t(count[2]);
    }
    std::size_t index(int x, int y, int z) const {
        return (std::size_t(z) * std::size_t(count[1]) + std::size_t(y)) * std::size_t(count[0]) +
               std::size_t(x);
    }
    Vec3 center(int x, int y, int z) const {
        return low + size * (Vec3(float(x), float(y), float(z)) + 0.5f);
    }
    /// Coordinate of the cell of a point along one axis, not limited to the box.
    int along(int axis, float at) const { return int(std::floor((at - low[axis]) / size)); }
    bool holds(Vec3 p) const {
        const Vec3 d = (p - low) / size;
        return d.x >= 0 && d.y >= 0 && d.z >= 0 && d.x < float(count[0]) && d.y < float(count[1]) &&
               d.z < float(count[2]);
    }
};

/// Signed distances to a surface at the cells' centres, from which any point gets a lower bound:
/// distances change by no more than the way between two points.
class DistanceGrid {
public:
    /// `distance` gives the distance to the surface, negative outside, and is called from any
    /// thread.
    DistanceGrid(const Cells& cells, const std::function<float(Vec3)>& distance);

    /// At most the distance from x to the surface if x is inside. Negative only if x is outside;
    /// a point just outside may get a small positive bound.
    float clearance(Vec3 x) const {
        if (!cells_.holds(x)) return -1;
        const Vec3 d = (x - cells_.low) / cells_.size;
        const int i = int(d.x), j = int(d.y), k = int(d.z);
        const float at_center = distance_[cells_.index(i, j, k)];
        const float offset = glm::length(x - cells_.center(i, j, k));
        if (at_center + offset < 0) return at_center + offset;
        return std::max(0.0f, at_center - offset);
    }

    const Cells& cells() const { return cells_; }

private:
    Cells cells_;
    std::vector<float> distance_;
};

}  // namespace tallow::reference
