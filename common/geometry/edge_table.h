// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/mesh.h"

namespace tallow {

/// The edges of triangles and who uses them. Half-edge 3 t + c is that of triangle t from its
/// corner c to the next; an edge is the group of half-edges between two vertices, whichever way.
class EdgeTable {
public:
    EdgeTable(std::span<const Triangle> triangles, std::size_t vertices);

    std::size_t size() const { return first_.size() - 1; }
    /// The half-edges of an edge, ascending.
    std::span<const std::uint32_t> around(std::size_t edge) const {
        return std::span(half_edges_).subspan(first_[edge], first_[edge + 1] - first_[edge]);
    }

private:
    std::vector<std::uint32_t> half_edges_;  // grouped by edge
    std::vector<std::size_t> first_;         // [edge] begin of its group, and the end of all
};

inline std::uint32_t next_half_edge(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
inline std::uint32_t previous_half_edge(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

/// The vertex where a half-edge begins.
inline std::uint32_t source(std::span<const Triangle> triangles, std::uint32_t h) {
    return triangles[h / 3][h % 3];
}
inline std::uint32_t target(std::span<const Triangle> triangles, std::uint32_t h) {
    return source(triangles, next_half_edge(h));
}

}  // namespace tallow
