// SPDX-License-Identifier: Apache-2.0
//
// Triangles in, their edges out: half-edges are dealt out to the smaller of their vertices by a
// counting sort, then each vertex sorts its few by the larger one.

#include "common/geometry/edge_table.h"

#include <algorithm>
#include <utility>

namespace tallow {

EdgeTable::EdgeTable(std::span<const Triangle> triangles, std::size_t vertices)
    : half_edges_(3 * triangles.size()) {
    const auto ends = [&](std::uint32_t h) {
        const std::pair<std::uint32_t, std::uint32_t> edge(source(triangles, h),
                                                           target(triangles, h));
        return edge.first < edge.second ? edge : std::pair(edge.second, edge.first);
    };
    std::vector<std::uint32_t> bucket(vertices + 2,
                                      0);  // [v + 1] begin of v's, once filled its end
    const auto count = static_cast<std::uint32_t>(half_edges_.size());
    for (std::uint32_t h = 0; h < count; ++h) ++bucket[ends(h).first + 2];
    for (std::size_t v = 2; v < bucket.size(); ++v) bucket[v] += bucket[v - 1];
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sorted(count);  // larger vertex, half-edge
    for (std::uint32_t h = 0; h < count; ++h) {
        const auto [low, high] = ends(h);
        sorted[bucket[low + 1]++] = {high, h};
    }
    first_.reserve(count / 2 + 1);
    for (std::size_t v = 0; v < vertices; ++v) {
        std::sort(sorted.begin() + bucket[v], sorted.begin() + bucket[v + 1]);
        for (std::size_t i = bucket[v]; i < bucket[v + 1]; ++i) {
            if (i == bucket[v] || sorted[i].first != sorted[i - 1].first) first_.push_back(i);
            half_edges_[i] = sorted[i].second;
        }
    }
    first_.push_back(count);
}

}  // namespace tallow
