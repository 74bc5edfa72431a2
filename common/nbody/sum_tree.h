// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.h"
#include "common/cloud/point_octree.h"

namespace tallow {

/// Weighted points under an octree, with the moments that let a node stand for its points: the
/// sources of an N-body sum. Laid out for SIMD: the children of a node lie side by side in a block.
///
/// Units    positions in `unit` (KernelTable::unit()), weights divided by weight_scale(), a power
/// of
///          two that brings their sum to about 1.
class SumTree {
public:
    static constexpr int kChildren = 8;
    static constexpr std::uint32_t kLeaf = ~std::uint32_t(0);

    /// Up to eight siblings; those that are missing have no weight, no extent and no points.
    struct alignas(64) Block {
        float x[kChildren], y[kChildren], z[kChildren];  // centroid of the weights
        float weight[kChildren];                         // W, sum of the weights beneath
        // Second moments about the centroid, sum of w d d^T.
        float xx[kChildren], yy[kChildren], zz[kChildren];
        float xy[kChildren], xz[kChildren], yz[kChildren];
        float radius[kChildren];  // of the ball about the centroid that holds all points
        float spread[kChildren];  // (sum of w |d|^3 / W)^(1/3), never above the radius
        float drift[kChildren];   // |sum of w d|: what rounding the centroid to float has left
        std::uint32_t child[kChildren];  // block of the node's own children, or kLeaf
        std::uint32_t first[kChildren], count[kChildren];  // its points
    };
    static_assert(sizeof(Block) == 512);

    struct Point {
        float x, y, z, weight;
    };
    /// Points without weight behind points(), so that whole registers may be read there.
    static constexpr std::size_t kPadding = 16;

    /// `nodes` is the topology over the points, in whose order positions[] (mm) and weights[] are.
    SumTree(std::span<const Vec3> positions, std::span<const float> weights,
            std::span<const OctreeNode> nodes, double unit);

    /// Block 0 holds the root alone. Empty for no points.
    std::span<const Block> blocks() const { return blocks_; }
    std::span<const Point> points() const { return {points_.data(), points_.size() - kPadding}; }
    double unit() const { return unit_; }
    double weight_scale() const { return weight_scale_; }
    double total_weight() const { return total_weight_; }

private:
    std::vector<Block> blocks_;
    std::vector<Point> points_;
    double unit_, weight_scale_ = 1, total_weight_ = 0;
};

}  // namespace tallow
