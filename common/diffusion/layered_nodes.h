// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/cloud/point_octree.h"

namespace tallow {

/// Topology of a tree over points that lie in layers beneath a surface, one of each sample in each
/// layer. Large nodes are those of the samples' tree; from some size on each layer has nodes of its
/// own, which are as flat as the surface and can stand for their points from near by.
class LayeredNodes {
public:
    /// `nodes` is the tree over the samples, `areas` [sample] theirs; nodes of `split_area` and
    /// less have layers of their own. Both areas in mm^2.
    LayeredNodes(std::span<const OctreeNode> nodes, std::span<const float> areas,
                 std::uint32_t layers, double split_area);

    std::span<const OctreeNode> nodes() const { return out_; }
    std::uint32_t layers() const { return layers_; }
    /// The number of points.
    std::size_t size() const { return layers_ * sample_.size(); }
    /// The point of a sample in a layer, in the order that nodes() refers to.
    std::size_t point(std::size_t sample, std::uint32_t layer) const {
        const Split& split = sample_[sample];
        return std::size_t(layers_) * split.first + layer * split.count + (sample - split.first);
    }

private:
    /// The samples of the node that is split into layers.
    struct Split {
        std::uint32_t first, count;
    };
    void add(std::size_t node, double split_area);
    void add_layer(std::size_t node, std::uint32_t first);

    std::span<const OctreeNode> in_;
    std::vector<double> area_before_;  // [sample]
    std::uint32_t layers_;
    std::vector<OctreeNode> out_;
    std::vector<Split> sample_;
};

}  // namespace tallow
