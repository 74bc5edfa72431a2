// SPDX-License-Identifier: Apache-2.0
#include "experiments/reference/distance_grid.h"

#include <algorithm>
#include <cmath>

#include "common/base/parallel.h"

namespace tallow::reference {

Cells::Cells(const Box& box, double wanted) {
    const DVec3 extent = DVec3(box.high) - DVec3(box.low);
    const double longest = std::max({extent.x, extent.y, extent.z});
    const double volume =
        std::max(extent.x * extent.y * extent.z, 1e-6 * longest * longest * longest);
    size = float(std::max(std::cbrt(volume / wanted), longest / 1000));
    for (int axis = 0; axis < 3; ++axis) count[axis] = int(extent[axis] / double(size)) + 2;
    for (int axis = 0; axis < 3; ++axis)
        low[axis] = (box.low[axis] + box.high[axis] - float(count[axis]) * size) / 2;
}

DistanceGrid::DistanceGrid(const Cells& cells, const std::function<float(Vec3)>& distance)
    : cells_(cells), distance_(cells.total()) {
    parallel_for(std::size_t(cells_.count[2]), 1, [&](std::size_t k) {
        const int z = int(k);
        for (int y = 0; y < cells_.count[1]; ++y)
            for (int x = 0; x < cells_.count[0]; ++x)
                distance_[cells_.index(x, y, z)] = distance(cells_.center(x, y, z));
    });
}

}  // namespace tallow::reference
