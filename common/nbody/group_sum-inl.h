// SPDX-License-Identifier: Apache-2.0
// Sums over a tree for one group of points, compiled once for every instruction set.
//
// 1. From the root down, nodes that are far from the group (their remainder is below the threshold
//    for every point in the group's ball) are turned into one polynomial of second degree about the
//    group's center: sixteen nodes at a time, one kernel evaluation each for the whole group.
// 2. What is left over is offered to each packet of 16 points: first the same with the packet's
//    smaller ball; then nodes one by one with their moments, at last leaves point by point, SIMD
//    over the points of the packet, or over nodes and leaves if there are few points.
//
// Per-target include guard, as Highway asks for.
#if defined(TALLOW_GROUP_SUM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TALLOW_GROUP_SUM_INL_H
#undef TALLOW_GROUP_SUM_INL_H
#else
#define TALLOW_GROUP_SUM_INL_H
#endif

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/nbody/expansion-inl.h"
#include "common/nbody/group_sum.h"
#include "common/nbody/near_sources-inl.h"
#include "common/nbody/simd_kernel-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace tallow {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Nodes that are smaller than this times the group's radius are left to the packets rather than
// opened for the group: then it is the group's own size that stands in the way. Measured: 0.5 and 2
// are slower by up to a tenth.
constexpr float kLeftToPackets = 1;

// Of sixteen nodes some nearly always pass, and a branch on that is mispredicted; of fewer it pays.
constexpr bool kBranchless = kNodeLanes == 2 * SumTree::kChildren;

// Packets of at most so many points take nodes and leaves sixteen at a time. Sums that are
// certified never do: their bounds are of terms that are added up in order.
constexpr std::uint32_t kFewTargets = 8;

// Half a unit in the last place of 1: the relative rounding error of a float operation.
constexpr float kRounding = 0x1p-24f;

/// Sums at some points of a packet, and what certifies them. Terms are added up kRun at a time, and
/// the partial sums with compensation: of n terms in one go, n roundings could pile up.
template <bool kCertify>
struct PointSums {
    static constexpr std::uint32_t kRun = 32;

    PointVector px, py, pz, sum, total, lost;
    std::uint32_t run = 0;
    Certificate<Points> certificate;

    HWY_INLINE PointSums(const TargetGroups::Packet& packet, std::size_t first) {
        const Points d;
        px = hn::Load(d, packet.x + first);
        py = hn::Load(d, packet.y + first);
        pz = hn::Load(d, packet.z + first);
        sum = total = lost = hn::Zero(d);
    }

    // Knuth's sum of two floats and its error.
    HWY_INLINE void close_run() {
        const auto both = hn::Add(total, sum);
        const auto part = hn::Sub(both, total);
        const auto error = hn::Add(hn::Sub(total, hn::Sub(both, part)), hn::Sub(sum, part));
        lost = hn::Add(lost, error);
        total = both;
        sum = hn::Zero(Points());
        run = 0;
    }
    HWY_INLINE void count_term() {
        if (++run == kRun) close_run();
    }
    HWY_INLINE PointVector result() {
        close_run();
        return hn::Add(total, lost);
    }

    HWY_INLINE void add_point(const SumTree::Point& p, const KernelTable::View& kernel) {
        const Points d;
        count_term();
        const auto dx = hn::Sub(px, hn::Set(d, p.x)), dy = hn::Sub(py, hn::Set(d, p.y)),
                   dz = hn::Sub(pz, hn::Set(d, p.z));
        const auto u = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
        const Cubic<Points> cubic = find_cubic(d, kernel, u);
        const auto weight = hn::Set(d, p.weight), k0 = cubic.value();
        sum = hn::MulAdd(weight, k0, sum);
        if constexpr (kCertify) {
            certificate.add_point(d, weight, cubic, hn::Add(u, hn::Set(d, kernel.offset)));
        }
    }

    HWY_INLINE void add_node(const SumTree::Block& block, std::size_t lane,
                             const KernelTable::View& kernel) {
        const Points d;
        count_term();
        const auto dx = hn::Sub(px, hn::Set(d, block.x[lane])),
                   dy = hn::Sub(py, hn::Set(d, block.y[lane])),
                   dz = hn::Sub(pz, hn::Set(d, block.z[lane]));
        const auto u = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
        const Cubic<Points> cubic = find_cubic(d, kernel, u);
        const auto k0 = cubic.value(), k1 = cubic.first(), k2 = cubic.second();
        const auto xx = hn::Set(d, block.xx[lane]), yy = hn::Set(d, block.yy[lane]),
                   zz = hn::Set(d, block.zz[lane]), xy = hn::Set(d, 2 * block.xy[lane]),
                   xz = hn::Set(d, 2 * block.xz[lane]), yz = hn::Set(d, 2 * block.yz[lane]);
        const auto of_x = hn::MulAdd(xx, dx, hn::MulAdd(xy, dy, hn::Mul(xz, dz)));
        const auto of_y = hn::MulAdd(yy, dy, hn::Mul(yz, dz));
        const auto dqd = hn::MulAdd(of_x, dx, hn::MulAdd(of_y, dy, hn::Mul(hn::Mul(zz, dz), dz)));
        const auto trace = hn::Set(d, block.xx[lane] + block.yy[lane] + block.zz[lane]);
        const auto weight = hn::Set(d, block.weight[lane]);
        const auto second = hn::MulAdd(k1, trace, hn::Mul(hn::Add(k2, k2), dqd));
        sum = hn::Add(sum, hn::MulAdd(weight, k0, second));
        if constexpr (kCertify) {
            certificate.add_expansion(d, weight, cubic, u, hn::Add(u, hn::Set(d, kernel.offset)),
                                      hn::Set(d, block.radius[lane]));
        }
    }
};

/// A list that SIMD code appends to, kept from packet to packet.
class IndexList {
public:
    explicit IndexList(std::vector<std::uint32_t>& storage) : storage_(storage) {}

    /// Appends the chosen lanes.
    HWY_INLINE void append(hn::Vec<NodeIndices> values, NodeMask chosen) {
        const NodeIndices d;
        if (storage_.size() < size_ + kNodeLanes) storage_.resize(2 * (size_ + kNodeLanes));
        if constexpr (kNodeLanes == 2 * SumTree::kChildren) {
            // Not CompressStore: to memory, some processors compress hundreds of times slower.
            const auto mask = hn::RebindMask(d, chosen);
            hn::StoreU(hn::Compress(values, mask), d, storage_.data() + size_);
            size_ += hn::CountTrue(d, mask);
        } else {
            // g++ 12 copies Highway's table of permutations to the stack for each Compress.
            HWY_ALIGN std::uint32_t lanes[kNodeLanes];
            hn::Store(values, d, lanes);
            for (std::uint32_t rest = mask_bits(chosen); rest != 0; rest &= rest - 1)
                storage_[size_++] = lanes[std::countr_zero(rest)];
        }
    }
    std::uint32_t operator[](std::size_t i) const { return storage_[i]; }
    std::size_t size() const { return size_; }

private:
    std::vector<std::uint32_t>& storage_;
    std::size_t size_ = 0;
};

/// Sums of one group, see the head of this file. Blocks are visited two at a time in the order in
/// which they were found: what follows then does not wait for what came just before.
template <bool kCertify>
class GroupSummer {
public:
    GroupSummer(const GroupSumInput& input, NodeThresholds thresholds, GroupSumState& state)
        : in_(input), thresholds_(thresholds), state_(state) {}

    void run() {
        const Ball ball{in_.group.center, in_.group.radius};
        state_.near.clear();
        Expansion expansion;
        if (in_.group.packets > 1)
            expand_for_group(ball, expansion);
        else
            state_.near.push_back({0, 1});
        const Polynomial polynomial(expansion, ball.center);
        state_.group_evaluations = expansion.nodes;
        const float bound = kCertify ? bound_of(expansion) : 0;
        state_.packets.resize(in_.group.packets);
        for (std::uint32_t p = 0; p < in_.group.packets; ++p)
            sum_packet(in_.packets[p], polynomial, bound, state_.packets[p]);
    }

private:
    static constexpr std::uint32_t kAllChildren = (1u << SumTree::kChildren) - 1;
    // Nodes of so few points are summed point by point: their moments cost twice as much as a
    // point.
    static constexpr std::uint32_t kFewPoints = 2;

    // Calls visit(siblings, mask of the lanes that count) for all lanes of two blocks.
    template <class Visit>
    HWY_INLINE void for_lanes(std::uint32_t first, std::uint32_t second, std::uint32_t lanes,
                              const Visit& visit) {
        Siblings nodes{&in_.blocks[first], &in_.blocks[second], first, second, 0};
        for (; nodes.lane < 2 * SumTree::kChildren; nodes.lane += kNodeLanes)
            if (lanes >> nodes.lane != 0) visit(nodes, lane_mask(lanes >> nodes.lane));
    }

    // Calls visit for the children of all queued blocks, also of those that it queues.
    template <class Visit>
    HWY_INLINE void for_queue(const IndexList& queue, const Visit& visit) {
        for (std::size_t i = 0, step; i < queue.size(); i += step) {
            const bool two = i + 1 < queue.size();
            step = two ? 2 : 1;
            for_lanes(queue[i], queue[i + two],
                      two ? kAllChildren << SumTree::kChildren | kAllChildren : kAllChildren,
                      visit);
        }
    }

    void expand_for_group(const Ball& ball, Expansion& expansion) {
        IndexList queue(state_.queue);
        const auto visit = [&](const Siblings& nodes, NodeMask wanted) HWY_ATTR {
            const Nodes d;
            const NodeIndices di;
            const auto lanes = hn::And(wanted, nodes.lit());
            const Distance at(nodes, ball, in_.kernel);
            const auto small = hn::And(lanes, hn::Le(at.expanded, at.limit(thresholds_)));
            expansion.steps += 1;
            if (kBranchless || !hn::AllFalse(d, small))
                expand<kCertify>(nodes, small, ball, at, in_.kernel, expansion);
            const auto rest = hn::AndNot(small, lanes);
            const auto children = nodes.load(di, &SumTree::Block::child);
            const auto is_leaf = hn::RebindMask(d, hn::Eq(children, hn::Set(di, SumTree::kLeaf)));
            const auto is_small = hn::Le(nodes.load(&SumTree::Block::radius),
                                         hn::Set(d, kLeftToPackets * ball.radius));
            const auto left = hn::And(rest, hn::Or(is_leaf, is_small));
            queue.append(children, hn::AndNot(left, rest));
            leave(nodes, mask_bits(left));
        };
        for_lanes(0, 0, 1, visit);
        for_queue(queue, visit);
    }

    // Puts children of one or two blocks on the list of what the packets have to look at.
    HWY_INLINE void leave(const Siblings& nodes, std::uint32_t lanes) {
        const std::uint32_t all = lanes << nodes.lane;
        if (const std::uint32_t bits = all & kAllChildren)
            state_.near.push_back({nodes.first_index, bits});
        if (const std::uint32_t bits = all >> SumTree::kChildren)
            state_.near.push_back({nodes.second_index, bits});
    }

    void sum_packet(const TargetGroups::Packet& packet, const Polynomial& of_group,
                    float bound_of_group, GroupSumState::PacketResult& result) {
        const Ball ball{packet.center, packet.radius};
        IndexList queue(state_.queue), single_nodes(state_.nodes), leaves(state_.leaves);
        Expansion expansion;
        NodeVector remainder = hn::Zero(Nodes());
        const auto visit = [&](const Siblings& nodes, NodeMask wanted) HWY_ATTR {
            const Nodes d;
            const NodeIndices di;
            const auto lanes = hn::And(wanted, nodes.lit());
            const Distance at(nodes, ball, in_.kernel);
            const auto limit = at.limit(thresholds_);
            const auto small = hn::And(lanes, hn::Le(at.expanded, limit));
            expansion.steps += 1;
            if (kBranchless || !hn::AllFalse(d, small))
                expand<kCertify>(nodes, small, ball, at, in_.kernel, expansion);
            const auto rest = hn::AndNot(small, lanes);
            const auto children = nodes.load(di, &SumTree::Block::child);
            const auto counts = nodes.load(di, &SumTree::Block::count);
            const auto is_leaf = hn::RebindMask(d, hn::Eq(children, hn::Set(di, SumTree::kLeaf)));
            const auto is_few = hn::RebindMask(d, hn::Lt(counts, hn::Set(di, kFewPoints + 1)));
            const auto usable = hn::And(rest, hn::AndNot(is_few, hn::Le(at.pointwise, limit)));
            const auto opened = hn::AndNot(usable, rest);
            const auto point_by_point = hn::And(opened, hn::Or(is_leaf, is_few));
            queue.append(children, hn::AndNot(point_by_point, opened));
            single_nodes.append(nodes.ids(), usable);
            leaves.append(nodes.ids(), point_by_point);
            if constexpr (kCertify)
                remainder = hn::Add(
                    remainder, hn::IfThenElseZero(
                                   usable, hn::Add(at.pointwise,
                                                   drift_remainder(nodes, ball, at, in_.kernel))));
        };
        for (std::size_t i = 0; i < state_.near.size(); i += 2) {
            const GroupSumState::Node first = state_.near[i];
            const bool two = i + 1 < state_.near.size();
            const GroupSumState::Node second =
                two ? state_.near[i + 1] : GroupSumState::Node{first.block, 0};
            for_lanes(first.block, second.block, second.lanes << SumTree::kChildren | first.lanes,
                      visit);
        }
        for_queue(queue, visit);
        if (!kCertify && packet.count <= kFewTargets)
            add_to_few(packet, ball, of_group, expansion, single_nodes, leaves, result);
        else
            add_points(packet, ball, of_group, expansion, single_nodes, leaves, result);
        if constexpr (kCertify)
            result.bound = 1.001f * (bound_of_group + bound_of(expansion) + result.bound +
                                     total(Nodes(), remainder) / 6);
    }

    void add_points(const TargetGroups::Packet& packet, const Ball& ball,
                    const Polynomial& of_group, const Expansion& expansion,
                    const IndexList& single_nodes, const IndexList& leaves,
                    GroupSumState::PacketResult& result) {
        const Points d;
        const Polynomial polynomial(expansion, ball.center);
        std::uint32_t evaluations = 0;
        float rounding = 0;
        for (std::size_t i = 0; i < TargetGroups::kPacketSize; i += hn::MaxLanes(d)) {
            PointSums<kCertify> sums(packet, i);
            for (std::size_t k = 0; k < single_nodes.size(); ++k) {
                const std::uint32_t node = single_nodes[k];
                sums.add_node(in_.blocks[node / SumTree::kChildren], node % SumTree::kChildren,
                              in_.kernel);
            }
            evaluations = std::uint32_t(single_nodes.size());
            for (std::size_t k = 0; k < leaves.size(); ++k) {
                const SumTree::Block& block = in_.blocks[leaves[k] / SumTree::kChildren];
                const std::uint32_t lane = leaves[k] % SumTree::kChildren;
                const SumTree::Point* points = in_.points + block.first[lane];
                for (std::uint32_t j = 0; j < block.count[lane]; ++j)
                    sums.add_point(points[j], in_.kernel);
                evaluations += block.count[lane];
            }
            auto far = of_group.at(sums.px, sums.py, sums.pz);
            if (expansion.nodes > 0) far = hn::Add(far, polynomial.at(sums.px, sums.py, sums.pz));
            hn::Store(hn::Add(far, sums.result()), d, result.sum + i);
            if constexpr (kCertify) {
                const auto per_term = hn::Set(d, float(PointSums<kCertify>::kRun + 4));
                const auto all =
                    hn::MulAdd(per_term, sums.certificate.terms, sums.certificate.rounding);
                const float worst = hn::GetLane(hn::MaxOfLanes(d, all));
                if (!(worst <= rounding)) rounding = worst;  // NaN, too
            }
        }
        result.bound = kRounding * rounding;
        result.evaluations = evaluations + expansion.nodes;
    }

    void add_to_few(const TargetGroups::Packet& packet, const Ball& ball,
                    const Polynomial& of_group, const Expansion& expansion,
                    const IndexList& single_nodes, const IndexList& leaves,
                    GroupSumState::PacketResult& result) {
        const Points d;
        std::uint32_t points = 0;
        for (std::size_t k = 0; k < leaves.size(); ++k)
            points +=
                in_.blocks[leaves[k] / SumTree::kChildren].count[leaves[k] % SumTree::kChildren];
        NearSources sources(state_);
        sources.reserve(points, single_nodes.size());
        for (std::size_t k = 0; k < leaves.size(); ++k) {
            const SumTree::Block& block = in_.blocks[leaves[k] / SumTree::kChildren];
            const std::uint32_t lane = leaves[k] % SumTree::kChildren;
            sources.add_points(in_.points + block.first[lane], block.count[lane]);
        }
        for (std::size_t k = 0; k < single_nodes.size(); ++k)
            sources.add_node(in_.blocks[single_nodes[k] / SumTree::kChildren],
                             single_nodes[k] % SumTree::kChildren);
        sources.close();
        const Polynomial polynomial(expansion, ball.center);
        for (std::size_t i = 0; i < TargetGroups::kPacketSize; i += hn::MaxLanes(d)) {
            const auto x = hn::Load(d, packet.x + i), y = hn::Load(d, packet.y + i),
                       z = hn::Load(d, packet.z + i);
            auto far = of_group.at(x, y, z);
            if (expansion.nodes > 0) far = hn::Add(far, polynomial.at(x, y, z));
            hn::Store(far, d, result.sum + i);
        }
        for (std::uint32_t i = 0; i < packet.count; ++i)
            result.sum[i] += sources.sum_at(packet.x[i], packet.y[i], packet.z[i], in_.kernel);
        std::fill(result.sum + packet.count, std::end(result.sum), result.sum[packet.count - 1]);
        result.bound = 0;
        result.evaluations = points + std::uint32_t(single_nodes.size()) + expansion.nodes;
    }

    float bound_of(const Expansion& e) const {
        const Nodes d;
        return total(d, e.certificate.remainder) / 6 +
               kRounding * (total(d, e.certificate.rounding) +
                            float(e.steps + 16) * total(d, e.certificate.terms));
    }

    const GroupSumInput& in_;
    NodeThresholds thresholds_;
    GroupSumState& state_;
};

void sum_group(const GroupSumInput& input, NodeThresholds thresholds, GroupSumState& state) {
    GroupSummer<false>(input, thresholds, state).run();
}

void sum_group_certified(const GroupSumInput& input, float threshold, GroupSumState& state) {
    GroupSummer<true>(input, {threshold, threshold}, state).run();
}

// Nodes of less than half their distance stand for their points, and leaves do anyway, at no less
// than their spread.
float estimate_group(const GroupSumInput& input, GroupSumState& state) {
    const Nodes d;
    const NodeIndices di;
    IndexList queue(state.queue);
    auto sum = hn::Zero(d);
    queue.append(hn::Zero(di), lane_mask(1));
    for (std::size_t i = 0, step; i < queue.size(); i += step) {
        const bool two = i + 1 < queue.size();
        step = two ? 2 : 1;
        const std::uint32_t first = queue[i], second = queue[i + two];
        Siblings nodes{&input.blocks[first], &input.blocks[second], first, second, 0};
        const std::size_t lanes = two ? 2 * SumTree::kChildren : SumTree::kChildren;
        for (; nodes.lane < lanes; nodes.lane += kNodeLanes) {
            const auto counted = lane_mask(((1u << lanes) - 1) >> nodes.lane);
            const auto dx =
                hn::Sub(hn::Set(d, input.group.center.x), nodes.load(&SumTree::Block::x));
            const auto dy =
                hn::Sub(hn::Set(d, input.group.center.y), nodes.load(&SumTree::Block::y));
            const auto dz =
                hn::Sub(hn::Set(d, input.group.center.z), nodes.load(&SumTree::Block::z));
            const auto u = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
            const auto radius = nodes.load(&SumTree::Block::radius),
                       spread = nodes.load(&SumTree::Block::spread);
            const auto children = nodes.load(di, &SumTree::Block::child);
            const auto is_leaf = hn::RebindMask(d, hn::Eq(children, hn::Set(di, SumTree::kLeaf)));
            const auto is_far = hn::Le(hn::Mul(hn::Set(d, 4), hn::Mul(radius, radius)), u);
            const auto used = hn::And(counted, hn::Or(is_leaf, is_far));
            const Cubic<Nodes> cubic =
                find_cubic(d, input.kernel, hn::Max(u, hn::Mul(spread, spread)));
            const auto weight = hn::IfThenElseZero(used, nodes.load(&SumTree::Block::weight));
            sum = hn::MulAdd(weight, cubic.value(), sum);
            queue.append(children, hn::AndNot(used, counted));
        }
    }
    return total(d, sum);
}

GroupSumFunctions functions() {
    return {hwy::TargetName(HWY_TARGET), estimate_group, sum_group, sum_group_certified};
}

}  // namespace HWY_NAMESPACE
}  // namespace tallow
HWY_AFTER_NAMESPACE();

#endif
