// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/geometry/mesh.h"
#include "render/refraction_bound.h"

namespace tallow {

/// Hierarchy over the triangles of a mesh by position and shading normal.
///
/// Memory   about 60 bytes a triangle.
class RefractionTree {
public:
    explicit RefractionTree(const TriangleMesh& mesh);

    /// Triangles in the order of the tree: neighbours follow one another.
    const std::vector<std::uint32_t>& order() const { return order_; }

    /// Calls visit(i) for all triangles order()[i] that `cull` lets pass with their node, and some
    /// more.
    template <class Visit>
    void visit(const RefractionCull& cull, Visit&& visit) const {
        for (std::size_t i = 0; i < nodes_.size();) {
            const Node& node = nodes_[i];
            if (!cull.may_refract(node.bound)) {
                i = node.skip;
                continue;
            }
            for (std::uint32_t k = 0; k < node.count; ++k) visit(node.first + k);
            ++i;
        }
    }

private:
    struct Node {
        PatchBound bound;
        std::uint32_t first, count;  // in order_, of a leaf; count is 0 for inner nodes
        std::uint32_t skip;          // the node after this one's subtree
    };

    void build(const TriangleMesh& mesh, const std::vector<Vec3>& centers, std::uint32_t first,
               std::uint32_t last);

    std::vector<Node> nodes_;           // depth first: the first child of node i is i + 1
    std::vector<std::uint32_t> order_;  // triangles, those of a leaf side by side
};

/// Ball around triangles and cone around their normals, of the corners where the mesh is smooth.
PatchBound bound_triangles(const TriangleMesh& mesh, const std::uint32_t* first,
                           const std::uint32_t* last);

}  // namespace tallow
