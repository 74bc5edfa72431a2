// SPDX-License-Identifier: Apache-2.0
// In: points and an octree's topology. Out: blocks of siblings with their moments. Moments of small
// nodes come straight from their points, those of large ones from their children's (parallel axes);
// both in double. What is combined only bounds the spread, from above (Minkowski's inequality).
#include "common/nbody/sum_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/parallel.h"

namespace tallow {
namespace {

constexpr std::uint32_t kDirect = 128;  // points up to which moments are taken from the points

float round_up(double value) {
    return std::nextafter(float(value), std::numeric_limits<float>::infinity());
}

/// Moments about the float centroid, in double.
struct Moments {
    DVec3 centroid{0};  // exact
    Vec3 center{0};     // the same, rounded
    double weight = 0, radius = 0, spread = 0;
    double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
};

class MomentBuilder {
public:
    MomentBuilder(std::span<const SumTree::Point> points, std::span<const OctreeNode> nodes)
        : points_(points), nodes_(nodes), moments_(nodes.size()) {}

    std::vector<Moments> build() {
        // Direct ones in parallel, then their ancestors, children before parents.
        parallel_for(nodes_.size(), 128, [&](std::size_t i) {
            if (nodes_[i].count <= kDirect || nodes_[i].skip == 1)
                moments_[i] = from_points(nodes_[i]);
        });
        for (std::size_t i = nodes_.size(); i-- > 0;)
            if (nodes_[i].count > kDirect && nodes_[i].skip > 1) moments_[i] = from_children(i);
        return std::move(moments_);
    }

private:
    static void add_second(Moments& m, double w, const DVec3& d) {
        m.xx += w * d.x * d.x, m.yy += w * d.y * d.y, m.zz += w * d.z * d.z;
        m.xy += w * d.x * d.y, m.xz += w * d.x * d.z, m.yz += w * d.y * d.z;
    }

    Moments from_points(const OctreeNode& node) const {
        Moments m;
        DVec3 mean(0);
        const auto points = points_.subspan(node.first, node.count);
        for (const SumTree::Point& p : points) {
            const DVec3 x(p.x, p.y, p.z);
            m.weight += p.weight;
            m.centroid += double(p.weight) * x;
            mean += x;
        }
        m.centroid = m.weight > 0 ? m.centroid / m.weight : mean / double(node.count);
        m.center = Vec3(m.centroid);
        double radius2 = 0, cubes = 0;
        for (const SumTree::Point& p : points) {
            const DVec3 d = DVec3(p.x, p.y, p.z) - DVec3(m.center);
            const double r2 = glm::dot(d, d);
            radius2 = std::max(radius2, r2);
            cubes += p.weight * r2 * std::sqrt(r2);
            add_second(m, p.weight, d);
        }
        m.radius = std::sqrt(radius2);
        m.spread = m.weight > 0 ? std::cbrt(cubes / m.weight) : 0;
        return m;
    }

    Moments from_children(std::size_t i) const {
        Moments m;
        for_each_child(i, [&](const Moments& child) {
            m.weight += child.weight;
            m.centroid += child.weight * child.centroid;
        });
        if (m.weight <= 0) return from_points(nodes_[i]);
        m.centroid /= m.weight;
        m.center = Vec3(m.centroid);
        double cubes = 0;
        for_each_child(i, [&](const Moments& child) {
            const DVec3 d = DVec3(child.center) - DVec3(m.center);
            const double distance = glm::length(d);
            m.radius = std::max(m.radius, distance + child.radius);
            const double reach = distance + child.spread;
            cubes += child.weight * reach * reach * reach;
            // The child's points about ours: Q + e d^T + d e^T + W d d^T, e its first moment.
            const DVec3 e = child.weight * (child.centroid - DVec3(child.center));
            add_second(m, child.weight, d);
            m.xx += child.xx + 2 * e.x * d.x;
            m.yy += child.yy + 2 * e.y * d.y;
            m.zz += child.zz + 2 * e.z * d.z;
            m.xy += child.xy + e.x * d.y + e.y * d.x;
            m.xz += child.xz + e.x * d.z + e.z * d.x;
            m.yz += child.yz + e.y * d.z + e.z * d.y;
        });
        m.spread = std::cbrt(cubes / m.weight);
        return m;
    }

    template <class Use>
    void for_each_child(std::size_t i, const Use& use) const {
        for (std::size_t c = i + 1; c < i + nodes_[i].skip; c += nodes_[c].skip) use(moments_[c]);
    }

    std::span<const SumTree::Point> points_;
    std::span<const OctreeNode> nodes_;
    std::vector<Moments> moments_;
};

void put(SumTree::Block& block, int lane, const Moments& m, const OctreeNode& node,
         std::uint32_t child) {
    block.x[lane] = m.center.x, block.y[lane] = m.center.y, block.z[lane] = m.center.z;
    block.weight[lane] = float(m.weight);
    block.xx[lane] = float(m.xx), block.yy[lane] = float(m.yy), block.zz[lane] = float(m.zz);
    block.xy[lane] = float(m.xy), block.xz[lane] = float(m.xz), block.yz[lane] = float(m.yz);
    block.radius[lane] = round_up(m.radius);
    block.spread[lane] = std::min(round_up(m.spread), block.radius[lane]);
    block.drift[lane] = round_up(m.weight * glm::length(m.centroid - DVec3(m.center)));
    block.child[lane] = child;
    block.first[lane] = node.first, block.count[lane] = node.count;
}

/// Nodes that share a block.
struct Siblings {
    int count = 0;
    std::uint32_t node[SumTree::kChildren];
};

/// Which nodes lie together in which block.
class BlockPlan {
public:
    explicit BlockPlan(std::span<const OctreeNode> nodes)
        : nodes_(nodes), block_of_(nodes.size(), SumTree::kLeaf) {
        blocks_.push_back({1, {0}});
        std::vector<char> has_block(nodes.size());
        has_block[0] = nodes[0].skip > 1;
        for (std::uint32_t i = 0; i < nodes.size(); ++i) {
            if (!has_block[i]) continue;
            block_of_[i] = std::uint32_t(blocks_.size());
            const Siblings& siblings = blocks_.emplace_back(descendants(i));
            for (int k = 0; k < siblings.count; ++k)
                has_block[siblings.node[k]] = nodes[siblings.node[k]].skip > 1;
        }
    }

    /// The root's, and then in the order of the nodes whose descendants they hold.
    std::span<const Siblings> blocks() const { return blocks_; }
    /// The block that holds the descendants of a node, or kLeaf if none does: leaves have none, and
    /// nodes in whose place their children lie need none.
    std::uint32_t block_of(std::uint32_t node) const { return block_of_[node]; }

private:
    // The children of a node; and as long as there is room, those of the largest child in its
    // place. On a surface an octant has four children: blocks would be half empty.
    Siblings descendants(std::uint32_t parent) const {
        Siblings result;
        int children[SumTree::kChildren];  // of the siblings
        const auto put = [&](int k, std::uint32_t node) {
            result.node[k] = node;
            children[k] = 0;
            for_each_child(node, [&](std::uint32_t) { ++children[k]; });
        };
        const auto add_children = [&](std::uint32_t i) {
            for_each_child(i, [&](std::uint32_t c) { put(result.count++, c); });
        };
        add_children(parent);
        for (;;) {
            int largest = -1;
            for (int k = 0; k < result.count; ++k)
                if (children[k] > 0 && result.count - 1 + children[k] <= SumTree::kChildren &&
                    (largest < 0 ||
                     nodes_[result.node[k]].count > nodes_[result.node[largest]].count))
                    largest = k;
            if (largest < 0) return result;
            const std::uint32_t opened = result.node[largest];
            --result.count;
            result.node[largest] = result.node[result.count];
            children[largest] = children[result.count];
            add_children(opened);
        }
    }

    template <class Use>
    void for_each_child(std::uint32_t i, const Use& use) const {
        for (std::uint32_t c = i + 1; c < i + nodes_[i].skip; c += nodes_[c].skip) use(c);
    }

    std::span<const OctreeNode> nodes_;
    std::vector<std::uint32_t> block_of_;  // [node]
    std::vector<Siblings> blocks_;
};

}  // namespace

SumTree::SumTree(std::span<const Vec3> positions, std::span<const float> weights,
                 std::span<const OctreeNode> nodes, double unit)
    : points_(positions.size() + kPadding), unit_(unit) {
    if (nodes.empty()) return;
    for (const float w : weights) total_weight_ += w;
    if (total_weight_ > 0) weight_scale_ = std::exp2(std::floor(std::log2(total_weight_)));
    const float to_units = float(1 / unit);
    parallel_for(positions.size(), 8192, [&](std::size_t j) {
        const Vec3 p = to_units * positions[j];
        points_[j] = {p.x, p.y, p.z, float(weights[j] / weight_scale_)};
    });
    const std::vector<Moments> moments = MomentBuilder(points(), nodes).build();

    const BlockPlan plan(nodes);
    blocks_.resize(plan.blocks().size());
    parallel_for(blocks_.size(), 128, [&](std::size_t b) {
        blocks_[b] = {};
        std::fill_n(blocks_[b].child, kChildren, kLeaf);
        const Siblings& siblings = plan.blocks()[b];
        for (int lane = 0; lane < siblings.count; ++lane) {
            const std::uint32_t node = siblings.node[lane];
            put(blocks_[b], lane, moments[node], nodes[node], plan.block_of(node));
        }
    });
}

}  // namespace tallow
