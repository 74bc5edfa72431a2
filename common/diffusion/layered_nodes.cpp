// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/layered_nodes.h"

#include <algorithm>

namespace tallow {
namespace {

// Points of a leaf at most. Measured on the bunny: with 8, making the trees takes a quarter longer,
// and summing over them as long.
constexpr std::uint32_t kLargestLeaf = 16;

}  // namespace

LayeredNodes::LayeredNodes(std::span<const OctreeNode> nodes, std::span<const float> areas,
                           std::uint32_t layers, double split_area)
    : in_(nodes), layers_(layers), sample_(areas.size()) {
    area_before_.reserve(areas.size() + 1);
    area_before_.push_back(0);
    for (const float a : areas) area_before_.push_back(area_before_.back() + double(a));
    out_.reserve(nodes.size());
    if (!nodes.empty()) add(0, split_area);
}

// Depth first, as in_ is.
void LayeredNodes::add(std::size_t node, double split_area) {
    const OctreeNode& of_samples = in_[node];
    const std::size_t end = of_samples.first + of_samples.count;
    const std::size_t own = out_.size();
    out_.push_back({layers_ * of_samples.first, layers_ * of_samples.count, 1});
    if (of_samples.skip == 1 || area_before_[end] - area_before_[of_samples.first] <= split_area) {
        std::fill(sample_.begin() + of_samples.first, sample_.begin() + std::ptrdiff_t(end),
                  Split{of_samples.first, of_samples.count});
        for (std::uint32_t k = 0; k < layers_; ++k)
            add_layer(node, layers_ * of_samples.first + k * of_samples.count);
    } else {
        for (std::size_t c = node + 1; c < node + of_samples.skip; c += in_[c].skip)
            add(c, split_area);
    }
    out_[own].skip = std::uint32_t(out_.size() - own);
}

// A node of one layer whose points begin at `first`.
void LayeredNodes::add_layer(std::size_t node, std::uint32_t first) {
    const OctreeNode& of_samples = in_[node];
    const std::size_t own = out_.size();
    out_.push_back({first, of_samples.count, 1});
    if (of_samples.count > kLargestLeaf)
        for (std::size_t c = node + 1; c < node + of_samples.skip; c += in_[c].skip)
            add_layer(c, first + in_[c].first - of_samples.first);
    out_[own].skip = std::uint32_t(out_.size() - own);
}

}  // namespace tallow
