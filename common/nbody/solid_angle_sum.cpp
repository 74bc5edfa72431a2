// SPDX-License-Identifier: Apache-2.0
// Fluxes and centroids of a tree's nodes, straight from the points beneath each node: in double, so
// that a node's weight is its points' to rounding.
#include "common/nbody/solid_angle_sum.h"

#include <algorithm>

#include "common/base/parallel.h"

namespace tallow {

SolidAngleSum::SolidAngleSum(std::span<const Vec3> positions, std::span<const float> weights,
                             std::span<const float> areas, std::span<const OctreeNode> nodes)
    : nodes_(nodes.size()), points_(positions.size()) {
    parallel_for(positions.size(), 8192, [&](std::size_t j) {
        points_[j] = {positions[j], weights[j]};
    });
    parallel_for(nodes.size(), 256, [&](std::size_t i) {
        const auto [first, count, skip] = nodes[i];
        double weight = 0, area = 0;
        DVec3 weighted(0), mean(0);
        for (std::uint32_t j = first; j < first + count; ++j) {
            weight += weights[j];
            area += areas[j];
            weighted += double(weights[j]) * DVec3(positions[j]);
            mean += DVec3(positions[j]) / double(count);
        }
        const Vec3 centroid(weight > 0 ? weighted / weight : mean);
        float radius2 = 0;
        for (std::uint32_t j = first; j < first + count; ++j)
            radius2 = std::max(radius2, length2(positions[j] - centroid));
        nodes_[i] = {centroid, float(weight), radius2, float(area), first, count, skip};
    });
}

}  // namespace tallow
