// SPDX-License-Identifier: Apache-2.0
// Points in Morton order -> nodes, depth first. The octants of a node are contiguous runs of codes
// that agree in their leading bits; finding where the next three bits change is all there is to do.
#include "precompute/build_octree.h"

#include <algorithm>

#include "common/base/check.h"
#include "precompute/morton.h"

namespace tallow {
namespace {

class Builder {
public:
    explicit Builder(std::span<const std::uint64_t> codes) : codes_(codes) {}

    std::vector<OctreeNode> build() {
        if (!codes_.empty()) add_node(0, std::uint32_t(codes_.size()), kMortonBits);
        return std::move(nodes_);
    }

private:
    // Adds the node of points [first, last), whose codes agree above 3 * level bits.
    void add_node(std::uint32_t first, std::uint32_t last, int level) {
        const std::size_t self = nodes_.size();
        nodes_.push_back({first, last - first, 1});
        if (last - first > kLeafSize) add_children(first, last, level);
        nodes_[self].skip = std::uint32_t(nodes_.size() - self);
    }

    void add_children(std::uint32_t first, std::uint32_t last, int level) {
        // Points in one octant have no use for a node of their own: go down to where they part.
        do --level;
        while (level >= 0 && octant(first, level) == octant(last - 1, level));
        if (level < 0) return;  // all coincide: a leaf, however many they are
        while (first < last) {
            const std::uint32_t end = run_end(first, last, level);
            add_node(first, end, level);
            first = end;
        }
    }

    std::uint64_t octant(std::uint32_t i, int level) const { return codes_[i] >> (3 * level); }

    std::uint32_t run_end(std::uint32_t first, std::uint32_t last, int level) const {
        const auto end =
            std::upper_bound(codes_.begin() + first, codes_.begin() + last, octant(first, level),
                             [level](std::uint64_t value, std::uint64_t code) {
                                 return value < code >> (3 * level);
                             });
        return std::uint32_t(end - codes_.begin());
    }

    std::span<const std::uint64_t> codes_;
    std::vector<OctreeNode> nodes_;
};

}  // namespace

std::vector<OctreeNode> build_octree(std::span<const Vec3> positions) {
    const std::vector<std::uint64_t> codes = morton_codes(positions);
    TALLOW_CHECK(std::is_sorted(codes.begin(), codes.end()), "{} points", codes.size());
    return Builder(codes).build();
}

}  // namespace tallow
