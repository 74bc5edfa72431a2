// SPDX-License-Identifier: Apache-2.0
//
// A triangle soup in, whether it is an oriented two-manifold out, and its connected components.
// Linear in the triangles; 28 bytes a triangle at most.

#include <algorithm>
#include <atomic>
#include <limits>
#include <utility>

#include "common/base/parallel.h"

#include "common/geometry/edge_table.h"
#include "common/geometry/mesh_repair_steps.h"

namespace tallow {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// The half-edges that share their smaller vertex, one after the other.
struct EdgeStar {
    std::vector<std::uint32_t> half_edges;
    std::vector<std::uint32_t> first;  // [vertex] begin of its half-edges, and the end of all
};

EdgeStar group_by_smaller_vertex(const TriangleSoup& soup) {
    const auto smaller = [&](std::uint32_t h) {
        return std::min(source(soup.triangles, h), target(soup.triangles, h));
    };
    const auto count = static_cast<std::uint32_t>(3 * soup.triangles.size());
    EdgeStar star{std::vector<std::uint32_t>(count),
                  std::vector<std::uint32_t>(soup.vertices.size() + 2, 0)};
    // Shifted by one place: filling moves each begin to its end, which is the next one's begin.
    for (std::uint32_t h = 0; h < count; ++h) ++star.first[smaller(h) + 2];
    for (std::size_t v = 2; v < star.first.size(); ++v) star.first[v] += star.first[v - 1];
    for (std::uint32_t h = 0; h < count; ++h) star.half_edges[star.first[smaller(h) + 1]++] = h;
    star.first.pop_back();
    return star;
}

/// Links the half-edges of one star in pairs; false if three share an edge, or two run one way.
bool pair_up(const TriangleSoup& soup, std::span<std::uint32_t> star,
             std::vector<std::uint32_t>& opposite) {
    const auto larger = [&](std::uint32_t h) {
        return std::max(source(soup.triangles, h), target(soup.triangles, h));
    };
    std::ranges::sort(star, [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(larger(a), a) < std::pair(larger(b), b);
    });
    for (std::size_t i = 0; i + 1 < star.size(); ++i) {
        const std::uint32_t a = star[i], b = star[i + 1];
        if (larger(a) != larger(b)) continue;
        if (opposite[a] != kNone || source(soup.triangles, a) == source(soup.triangles, b))
            return false;
        opposite[a] = b;
        opposite[b] = a;
    }
    return true;
}

/// The half-edge on the other side of each, kNone on a border; empty if an edge has more than two
/// sides or both run the same way.
std::vector<std::uint32_t> find_opposites(const TriangleSoup& soup) {
    EdgeStar star = group_by_smaller_vertex(soup);
    std::vector<std::uint32_t> opposite(star.half_edges.size(), kNone);
    std::atomic<bool> paired = true;
    parallel_for(soup.vertices.size(), 4096, [&](std::size_t v) {
        const std::span<std::uint32_t> some(star.half_edges.data() + star.first[v],
                                            star.first[v + 1] - star.first[v]);
        if (!pair_up(soup, some, opposite)) paired = false;
    });
    return paired ? opposite : std::vector<std::uint32_t>();
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

std::optional<std::vector<std::uint32_t>> manifold_opposites(const TriangleSoup& soup) {
    if (soup.triangles.empty()) return std::vector<std::uint32_t>();
    std::vector<std::uint32_t> opposite = find_opposites(soup);
    if (opposite.empty() || has_twins(opposite)) return std::nullopt;
    std::vector<std::uint32_t> corners(soup.vertices.size(), 0), any(soup.vertices.size(), kNone);
    for (std::uint32_t h = 0; h < opposite.size(); ++h) {
        const std::uint32_t v = source(soup.triangles, h);
        ++corners[v];
        any[v] = h;
    }
    std::atomic<bool> fans = true;
    parallel_for(any.size(), 4096, [&](std::size_t v) {
        if (any[v] != kNone && fan_size(opposite, any[v]) != corners[v]) fans = false;
    });
    if (!fans) return std::nullopt;
    return opposite;
}

bool is_oriented_manifold(const TriangleSoup& soup) { return manifold_opposites(soup).has_value(); }

Components connected_components(std::span<const std::uint32_t> opposite) {
    Components result{std::vector<std::uint32_t>(opposite.size() / 3, kNone), {}};
    std::vector<std::uint32_t> front;
    for (std::uint32_t seed = 0; seed < result.of_triangle.size(); ++seed) {
        if (result.of_triangle[seed] != kNone) continue;
        const auto component = static_cast<std::uint32_t>(result.closed.size());
        result.closed.push_back(true);
        result.of_triangle[seed] = component;
        front.push_back(seed);
        while (!front.empty()) {
            const std::uint32_t triangle = front.back();
            front.pop_back();
            for (std::uint32_t h = 3 * triangle; h < 3 * triangle + 3; ++h) {
                if (opposite[h] == kNone) {
                    result.closed[component] = false;
                } else if (std::uint32_t& mark = result.of_triangle[opposite[h] / 3];
                           mark == kNone) {
                    mark = component;
                    front.push_back(opposite[h] / 3);
                }
            }
        }
    }
    return result;
}

}  // namespace tallow
