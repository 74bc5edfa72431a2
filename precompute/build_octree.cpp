// SPDX-License-Identifier: Apache-2.0
// Points in Morton order -> nodes, depth first. The octants of a node are contiguous runs of codes
// that agree in their leading bits; finding where the next three bits change is all there is to do.
// Large octants are built side by side and then joined: a node's links are relative, so that a
// subtree's nodes are the same wherever it stands.
#include "precompute/build_octree.h"

#include <algorithm>

#include "common/base/check.h"
#include "common/base/parallel.h"
#include "common/cloud/morton.h"

namespace tallow {
namespace {

using Nodes = std::vector<OctreeNode>;

// Points up to which a subtree is built by one thread. Chosen: some tens of microseconds of work.
constexpr std::uint32_t kSerialPoints = 1 << 14;

/// The points [first, last), whose codes agree above 3 * level bits.
struct Run {
    std::uint32_t first, last;
    int level;

    std::uint32_t size() const { return last - first; }
};

class Builder {
public:
    explicit Builder(std::span<const std::uint64_t> codes) : codes_(codes) {}

    /// The node of `run` and all below it.
    Nodes build(const Run& run) const {
        Nodes nodes;
        if (run.size() > kSerialPoints)
            join_octants(run, nodes);
        else
            append(run, nodes);
        return nodes;
    }

private:
    void append(const Run& run, Nodes& nodes) const {
        const std::size_t self = nodes.size();
        nodes.push_back({run.first, run.size(), 1});
        for_octants(run, [&](const Run& octant) { append(octant, nodes); });
        nodes[self].skip = std::uint32_t(nodes.size() - self);
    }

    /// The same, with an octant for each task.
    void join_octants(const Run& run, Nodes& nodes) const {
        std::vector<Run> octants;
        for_octants(run, [&](const Run& octant) { octants.push_back(octant); });
        std::vector<Nodes> subtrees(octants.size());
        parallel_for(octants.size(), 1, [&](std::size_t k) { subtrees[k] = build(octants[k]); });
        std::size_t count = 1;
        for (const Nodes& subtree : subtrees) count += subtree.size();
        nodes.reserve(count);
        nodes.push_back({run.first, run.size(), std::uint32_t(count)});
        for (const Nodes& subtree : subtrees)
            nodes.insert(nodes.end(), subtree.begin(), subtree.end());
    }

    /// Calls body(octant) for each octant that becomes a child; for none if the run is a leaf.
    template <class Body>
    void for_octants(const Run& run, const Body& body) const {
        if (run.size() <= kLeafSize) return;
        // Points in one octant have no use for a node of their own: go down to where they part.
        int level = run.level;
        do --level;
        while (level >= 0 && octant(run.first, level) == octant(run.last - 1, level));
        if (level < 0) return;  // all coincide: a leaf, however many they are
        for (std::uint32_t first = run.first; first < run.last;) {
            const std::uint32_t end = octant_end(first, run.last, level);
            body(Run{first, end, level});
            first = end;
        }
    }

    std::uint64_t octant(std::uint32_t i, int level) const { return codes_[i] >> (3 * level); }

    std::uint32_t octant_end(std::uint32_t first, std::uint32_t last, int level) const {
        const auto end =
            std::upper_bound(codes_.begin() + first, codes_.begin() + last, octant(first, level),
                             [level](std::uint64_t value, std::uint64_t code) {
                                 return value < code >> (3 * level);
                             });
        return std::uint32_t(end - codes_.begin());
    }

    std::span<const std::uint64_t> codes_;
};

}  // namespace

std::vector<OctreeNode> build_octree(std::span<const Vec3> positions) {
    if (positions.empty()) return {};
    const std::vector<std::uint64_t> codes = morton_codes(positions);
    TALLOW_CHECK(std::is_sorted(codes.begin(), codes.end()), "{} points", codes.size());
    return Builder(codes).build({0, std::uint32_t(codes.size()), kMortonBits});
}

}  // namespace tallow
