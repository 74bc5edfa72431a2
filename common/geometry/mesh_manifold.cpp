// SPDX-License-Identifier: Apache-2.0
//
// A triangle soup in, whether it is an oriented two-manifold out. Linear in the triangles.

#include <limits>

#include "common/geometry/edge_table.h"
#include "common/geometry/mesh_repair_steps.h"

namespace tallow {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// The half-edge on the other side of each, kNone on a border; empty if an edge has more than two
/// sides or both run the same way.
std::vector<std::uint32_t> find_opposites(const TriangleSoup& soup) {
    std::vector<std::uint32_t> opposite(3 * soup.triangles.size(), kNone);
    const EdgeTable edges(soup.triangles, soup.vertices.size());
    for (std::size_t e = 0; e < edges.size(); ++e) {
        const auto around = edges.around(e);
        if (around.size() == 1) continue;
        if (around.size() > 2 ||
            source(soup.triangles, around[0]) == source(soup.triangles, around[1]))
            return {};
        opposite[around[0]] = around[1];
        opposite[around[1]] = around[0];
    }
    return opposite;
}

/// How many triangles the fan around the source of `start` has that `start` is in.
std::size_t fan_size(std::span<const std::uint32_t> opposite, std::uint32_t start) {
    std::size_t size = 1;
    std::uint32_t h = start;
    for (;; ++size) {  // clockwise
        h = opposite[h];
        if (h == kNone) break;
        h = next_half_edge(h);
        if (h == start) return size;
    }
    for (h = opposite[previous_half_edge(start)]; h != kNone; h = opposite[previous_half_edge(h)])
        ++size;
    return size;
}

bool has_twins(std::span<const std::uint32_t> opposite) {
    for (std::size_t h = 0; h < opposite.size(); h += 3)
        for (std::size_t c = 0; c < 3; ++c)
            if (const std::uint32_t other = opposite[h + c];
                other != kNone && other / 3 == opposite[h + (c + 1) % 3] / 3)
                return true;
    return false;
}

}  // namespace

bool is_oriented_manifold(const TriangleSoup& soup) {
    const std::vector<std::uint32_t> opposite = find_opposites(soup);
    if (opposite.empty() || has_twins(opposite)) return soup.triangles.empty();
    std::vector<std::uint32_t> corners(soup.vertices.size(), 0), any(soup.vertices.size(), kNone);
    for (std::uint32_t h = 0; h < opposite.size(); ++h) {
        const std::uint32_t v = source(soup.triangles, h);
        ++corners[v];
        any[v] = h;
    }
    for (std::size_t v = 0; v < any.size(); ++v)
        if (any[v] != kNone && fan_size(opposite, any[v]) != corners[v]) return false;
    return true;
}

}  // namespace tallow
