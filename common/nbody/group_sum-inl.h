// SPDX-License-Identifier: Apache-2.0
// Sums over a tree for one group of points, compiled once for every instruction set.
//
// 1. From the root down, nodes that are far from the group (their remainder is below the threshold
//    for every point in the group's ball) are turned into one polynomial of second degree about the
//    group's center: eight nodes at a time, one kernel evaluation each for the whole group.
// 2. What is left over is offered to each packet of 16 points: first the same with the packet's
//    smaller ball; then nodes one by one with their moments, SIMD over the points; at last leaves
//    point by point.
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

#include "common/nbody/group_sum.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace tallow {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Nodes = hn::CappedTag<float, 2 * SumTree::kChildren>;      // lanes are nodes of two blocks
using Points = hn::CappedTag<float, TargetGroups::kPacketSize>;  // lanes are points of a packet
using NodeIndices = hn::RebindToUnsigned<Nodes>;
constexpr std::size_t kNodeLanes = hn::MaxLanes(Nodes());
using NodeVector = hn::Vec<Nodes>;
using PointVector = hn::Vec<Points>;

// Nodes that are smaller than this times the group's radius are left to the packets rather than
// opened for the group: then it is the group's own size that stands in the way. Measured: 0.5 and 2
// are slower by a few per cent.
constexpr float kLeftToPackets = 1;

// Half a unit in the last place of 1: the relative rounding error of a float operation.
constexpr float kRounding = 0x1p-24f;

/// A cubic for each lane, and where in it the lane is.
template <class D>
struct Cubic {
    hn::Vec<D> c0, c1, c2, c3, x;
    HWY_INLINE hn::Vec<D> value() const {
        return hn::MulAdd(x, hn::MulAdd(x, hn::MulAdd(x, c3, c2), c1), c0);
    }
    HWY_INLINE hn::Vec<D> first() const {
        const auto three_c3 = hn::Mul(hn::Set(D(), 3), c3);
        return hn::MulAdd(x, hn::MulAdd(x, three_c3, hn::Add(c2, c2)), c1);
    }
    /// With the absolute values of the coefficients: its value and derivatives bound all the terms
    /// that those of this one are added up from.
    HWY_INLINE Cubic absolute() const {
        return {hn::Abs(c0), hn::Abs(c1), hn::Abs(c2), hn::Abs(c3), x};
    }
    HWY_INLINE hn::Vec<D> second() const {
        const auto six_c3 = hn::Mul(hn::Set(D(), 6), c3);
        return hn::MulAdd(x, six_c3, hn::Add(c2, c2));
    }
};

template <class D>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> segment_index(D, const KernelTable::View& kernel,
                                                        hn::Vec<D> v) {
    const hn::RebindToUnsigned<D> du;
    const auto place = hn::ShiftRightSame(hn::BitCast(du, v), int(kernel.shift));
    const auto index = hn::Min(hn::Sub(place, hn::Set(du, kernel.first_index)),
                               hn::Set(du, kernel.size));  // the last one is 0
    return hn::BitCast(hn::RebindToSigned<D>(), index);
}

HWY_INLINE const KernelTable::Segment& segment_at(const KernelTable::Segment* segments,
                                                  std::uint32_t bytes) {
    return *reinterpret_cast<const KernelTable::Segment*>(reinterpret_cast<const char*>(segments) +
                                                          bytes);
}

#if HWY_TARGET == HWY_SCALAR
template <class D>
HWY_INLINE void load_cubics(D d, const KernelTable::Segment* segments, const std::uint32_t* offset,
                            Cubic<D>& cubic) {
    const KernelTable::Segment& s = segment_at(segments, *offset);
    cubic.c0 = hn::Set(d, s.c0), cubic.c1 = hn::Set(d, s.c1);
    cubic.c2 = hn::Set(d, s.c2), cubic.c3 = hn::Set(d, s.c3);
}

template <class D, class V>
HWY_INLINE hn::Vec<D> join(D, V low, V) {
    return low;  // never called: there is no half of one lane
}
#else
template <class D, class V>
HWY_INLINE hn::Vec<D> join(D d, V low, V high) {
    return hn::Combine(d, high, low);
}

// Rows of four to columns: within each 128-bit block, row i holds the coefficients of lane i.
template <class D>
HWY_INLINE void transpose(D d, hn::Vec<D> r0, hn::Vec<D> r1, hn::Vec<D> r2, hn::Vec<D> r3,
                          Cubic<D>& cubic) {
    const hn::Repartition<double, D> pairs;
    const auto low01 = hn::BitCast(pairs, hn::InterleaveLower(d, r0, r1));
    const auto low23 = hn::BitCast(pairs, hn::InterleaveLower(d, r2, r3));
    const auto high01 = hn::BitCast(pairs, hn::InterleaveUpper(d, r0, r1));
    const auto high23 = hn::BitCast(pairs, hn::InterleaveUpper(d, r2, r3));
    cubic.c0 = hn::BitCast(d, hn::InterleaveLower(pairs, low01, low23));
    cubic.c1 = hn::BitCast(d, hn::InterleaveUpper(pairs, low01, low23));
    cubic.c2 = hn::BitCast(d, hn::InterleaveLower(pairs, high01, high23));
    cubic.c3 = hn::BitCast(d, hn::InterleaveUpper(pairs, high01, high23));
}

// A vector whose 128-bit block b is the segment of lane 4 b + first.
template <class D>
HWY_INLINE hn::Vec<D> load_row(D d, const KernelTable::Segment* segments,
                               const std::uint32_t* offset, std::size_t first) {
    if constexpr (hn::MaxLanes(D()) <= 4) {
        return hn::Load(d, &segment_at(segments, offset[first]).c0);
    } else {
        const hn::Half<D> half;
        return join(d, load_row(half, segments, offset, first),
                    load_row(half, segments, offset + hn::MaxLanes(half), first));
    }
}

// Gather instructions take twice as long as these loads and shuffles.
template <class D>
HWY_INLINE void load_cubics(D d, const KernelTable::Segment* segments, const std::uint32_t* offset,
                            Cubic<D>& cubic) {
    transpose(d, load_row(d, segments, offset, 0), load_row(d, segments, offset, 1),
              load_row(d, segments, offset, 2), load_row(d, segments, offset, 3), cubic);
}
#endif

template <class D>
HWY_INLINE Cubic<D> find_cubic(D d, const KernelTable::View& kernel, hn::Vec<D> u) {
    const hn::RebindToUnsigned<D> du;
    const auto v = hn::Add(u, hn::Set(d, kernel.offset));
    const auto start = hn::And(hn::BitCast(du, v), hn::Set(du, ~std::uint32_t(0) << kernel.shift));
    const auto lanes_index = segment_index(d, kernel, v);
    Cubic<D> cubic;
    cubic.x = hn::Sub(v, hn::BitCast(d, start));
    HWY_ALIGN std::uint32_t offset[hn::MaxLanes(D())];
    hn::Store(hn::ShiftLeft<4>(hn::BitCast(du, lanes_index)), du, offset);
    static_assert(sizeof(KernelTable::Segment) == 16);
    // Through memory: taken out of the register one by one they would cost as much as all the rest.
    asm volatile("" : "+m"(offset));
    load_cubics(d, kernel.segments, offset, cubic);
    return cubic;
}

template <class D>
HWY_INLINE hn::Vec<D> look_up(D d, const KernelTable::View& kernel, const float* bounds,
                              hn::Vec<D> u) {
    const auto v = hn::Add(u, hn::Set(d, kernel.offset));
    return hn::GatherIndex(d, bounds, segment_index(d, kernel, v));
}

/// A ball of points.
struct Ball {
    Vec3 center;
    float radius;
};

/// What one node after the other adds to a certificate, besides its value.
template <class D>
struct Certificate {
    hn::Vec<D> remainder, rounding, terms;

    // Not default initializers: g++ compiles those without the target's instructions.
    HWY_INLINE Certificate() { remainder = rounding = terms = hn::Zero(D()); }

    /// Of an expansion of weight W about a distance whose square is u, used up to `reach` away from
    /// there. docs/EVALUATOR.md derives the factors.
    HWY_INLINE void add_expansion(D d, hn::Vec<D> weight, const Cubic<D>& cubic, hn::Vec<D> u,
                                  hn::Vec<D> v, hn::Vec<D> reach) {
        const Cubic<D> bound = cubic.absolute();
        const auto k0 = bound.value(), k1 = bound.first(), k2 = bound.second();
        const auto k3 = hn::Mul(hn::Set(d, 6), bound.c3);
        const auto reach2 = hn::Mul(reach, reach);
        // 2 (d reach + reach^2) and 4 u reach^2 are the most that K' and K'' are multiplied with.
        const auto first = hn::Mul(hn::Set(d, 2), hn::MulAdd(hn::Sqrt(u), reach, reach2));
        // In an order in which a derivative of 0 keeps the rest from overflowing.
        const auto times_second = [&](hn::Vec<D> k) HWY_ATTR {
            return hn::Mul(hn::Mul(hn::Mul(hn::Mul(k, hn::Set(d, 4)), u), reach), reach);
        };
        const auto sum = hn::Add(times_second(k2), hn::MulAdd(k1, first, k0));
        terms = hn::MulAdd(weight, sum, terms);
        // The derivatives are taken at a v that is wrong by 7 roundings of v.
        const auto slopes = hn::Add(k1, hn::Add(hn::Mul(k2, first), times_second(k3)));
        const auto shifted = hn::Mul(hn::Mul(hn::Set(d, 7), v), slopes);
        rounding = hn::MulAdd(weight, hn::MulAdd(hn::Set(d, 10), sum, shifted), rounding);
    }

    /// Of a single point.
    HWY_INLINE void add_point(D d, hn::Vec<D> weight, const Cubic<D>& cubic, hn::Vec<D> v) {
        const Cubic<D> bound = cubic.absolute();
        const auto k0 = bound.value();
        const auto shifted = hn::Mul(hn::Mul(hn::Set(d, 7), v), bound.first());
        terms = hn::MulAdd(weight, k0, terms);
        rounding = hn::MulAdd(weight, hn::MulAdd(hn::Set(d, 10), k0, shifted), rounding);
    }
};

template <class D>
HWY_INLINE float total(D d, hn::Vec<D> v) {
    return hn::GetLane(hn::SumOfLanes(d, v));
}

/// A polynomial of second degree about the center of a ball, in partial sums, lane by lane.
struct Expansion {
    NodeVector value, x, y, z, isotropic, xx, yy, zz, xy, xz, yz;
    Certificate<Nodes> certificate;
    std::uint32_t nodes = 0, steps = 0;

    HWY_INLINE Expansion() {
        value = x = y = z = isotropic = xx = yy = zz = xy = xz = yz = hn::Zero(Nodes());
    }
};

/// Some of the children of two blocks, as many as a vector has lanes. Lane i of [0, 16) is child
/// i mod 8 of the first block or the second.
struct Siblings {
    const SumTree::Block* first;
    const SumTree::Block* second;
    std::uint32_t first_index, second_index;
    std::size_t lane;  // the first of these

    template <class T, class D>
    HWY_INLINE hn::Vec<D> load(D d, const T (SumTree::Block::*field)[SumTree::kChildren]) const {
        if constexpr (kNodeLanes > SumTree::kChildren) {
            const hn::Half<D> half;
            return join(d, hn::Load(half, first->*field), hn::Load(half, second->*field));
        } else if (lane < SumTree::kChildren) {
            return hn::Load(d, first->*field + lane);
        } else {
            return hn::Load(d, second->*field + (lane - SumTree::kChildren));
        }
    }
    HWY_INLINE NodeVector load(const float (SumTree::Block::*field)[SumTree::kChildren]) const {
        return load(Nodes(), field);
    }
    /// Which have any weight: missing children have none.
    HWY_INLINE hn::Mask<Nodes> lit() const {
        return hn::Gt(load(&SumTree::Block::weight), hn::Zero(Nodes()));
    }
    /// Block * 8 + child, for each lane.
    HWY_INLINE hn::Vec<NodeIndices> ids() const {
        const NodeIndices d;
        if constexpr (kNodeLanes > SumTree::kChildren) {
            const hn::Half<NodeIndices> half;
            return join(d, hn::Iota(half, first_index * SumTree::kChildren),
                        hn::Iota(half, second_index * SumTree::kChildren));
        } else {
            const std::size_t child = lane % SumTree::kChildren;
            const std::uint32_t block = lane < SumTree::kChildren ? first_index : second_index;
            return hn::Iota(d, block * SumTree::kChildren + std::uint32_t(child));
        }
    }
};

using NodeMask = hn::Mask<Nodes>;

HWY_INLINE NodeMask lane_mask(std::uint32_t bits) {
    const std::uint8_t bytes[8] = {std::uint8_t(bits), std::uint8_t(bits >> 8)};
    return hn::LoadMaskBits(Nodes(), bytes);
}
HWY_INLINE std::uint32_t mask_bits(NodeMask mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(Nodes(), mask, bytes);
    constexpr std::uint32_t kAll = std::uint32_t((std::uint64_t(1) << kNodeLanes) - 1);
    return (bytes[0] | std::uint32_t(bytes[1]) << 8) & kAll;
}

/// How nodes lie to a ball: remainders, times 6, of standing for their points in an expansion about
/// the ball's center, or point by point.
struct Distance {
    NodeVector dx, dy, dz, u;        // from the centroid to the ball's center
    NodeVector reach;                // radii of the ball and of the node together
    NodeVector nearest2, third;      // least squared distance of two points, and its bound
    NodeVector expanded, pointwise;  // remainders

    /// Thresholds of the nodes, times 6 as the remainders.
    HWY_INLINE NodeVector limit(const NodeThresholds& thresholds) const {
        const Nodes d;
        const auto overlaps = hn::Eq(nearest2, hn::Zero(d));
        return hn::IfThenElse(overlaps, hn::Set(d, 6 * thresholds.overlapping),
                              hn::Set(d, 6 * thresholds.apart));
    }

    HWY_INLINE Distance(const Siblings& nodes, const Ball& ball, const KernelTable::View& kernel) {
        const Nodes d;
        dx = hn::Sub(hn::Set(d, ball.center.x), nodes.load(&SumTree::Block::x));
        dy = hn::Sub(hn::Set(d, ball.center.y), nodes.load(&SumTree::Block::y));
        dz = hn::Sub(hn::Set(d, ball.center.z), nodes.load(&SumTree::Block::z));
        u = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
        const auto ball_radius = hn::Set(d, ball.radius);
        const auto spread = nodes.load(&SumTree::Block::spread);
        reach = hn::Add(ball_radius, nodes.load(&SumTree::Block::radius));
        const auto nearest = hn::Max(  // rounded down
            hn::Zero(d), hn::NegMulAdd(hn::Set(d, 1.000001f), reach,
                                       hn::Mul(hn::Set(d, 0.999999f), hn::Sqrt(u))));
        nearest2 = hn::Mul(nearest, nearest);
        third = look_up(d, kernel, kernel.third, nearest2);
        const auto weighted = hn::Mul(nodes.load(&SumTree::Block::weight), third);
        const auto extent = hn::Add(ball_radius, spread);
        expanded = hn::Mul(weighted, hn::Mul(hn::Mul(extent, extent), extent));
        pointwise = hn::Mul(weighted, hn::Mul(hn::Mul(spread, spread), spread));
    }
};

// 6 times what rounding the centroids to float adds to a remainder.
HWY_INLINE NodeVector drift_remainder(const Siblings& nodes, const Ball& ball, const Distance& at,
                                      const KernelTable::View& kernel) {
    const Nodes d;
    const auto first = look_up(d, kernel, kernel.first, at.nearest2);
    const auto slope = hn::MulAdd(hn::Set(d, ball.radius * ball.radius), at.third, first);
    return hn::Mul(hn::Mul(hn::Set(d, 6), nodes.load(&SumTree::Block::drift)), slope);
}

// Adds nodes to an expansion about the center of the ball: the sum of w K(|D + a - b|^2) over a
// node's points b, to second order in a and b.
template <bool kCertify>
HWY_INLINE void expand(const Siblings& nodes, NodeMask chosen, const Ball& ball, const Distance& at,
                       const KernelTable::View& kernel, Expansion& e) {
    const Nodes d;
    const auto &dx = at.dx, &dy = at.dy, &dz = at.dz;
    const Cubic<Nodes> cubic = find_cubic(d, kernel, at.u);
    const auto k0 = hn::IfThenElseZero(chosen, cubic.value());
    const auto k1 = hn::IfThenElseZero(chosen, cubic.first());
    const auto k2 = hn::IfThenElseZero(chosen, cubic.second());
    const auto weight = nodes.load(&SumTree::Block::weight);
    e.nodes += std::uint32_t(hn::CountTrue(d, chosen));
    if constexpr (kCertify) {
        e.certificate.add_expansion(d, hn::IfThenElseZero(chosen, weight), cubic, at.u,
                                    hn::Add(at.u, hn::Set(d, kernel.offset)), at.reach);
        const auto remainder = hn::Add(at.expanded, drift_remainder(nodes, ball, at, kernel));
        e.certificate.remainder =
            hn::Add(e.certificate.remainder, hn::IfThenElseZero(chosen, remainder));
    }
    const auto xx = nodes.load(&SumTree::Block::xx), yy = nodes.load(&SumTree::Block::yy),
               zz = nodes.load(&SumTree::Block::zz), xy = nodes.load(&SumTree::Block::xy),
               xz = nodes.load(&SumTree::Block::xz), yz = nodes.load(&SumTree::Block::yz);
    const auto qx = hn::MulAdd(xx, dx, hn::MulAdd(xy, dy, hn::Mul(xz, dz)));
    const auto qy = hn::MulAdd(xy, dx, hn::MulAdd(yy, dy, hn::Mul(yz, dz)));
    const auto qz = hn::MulAdd(xz, dx, hn::MulAdd(yz, dy, hn::Mul(zz, dz)));
    const auto dqd = hn::MulAdd(qx, dx, hn::MulAdd(qy, dy, hn::Mul(qz, dz)));
    const auto trace = hn::Add(xx, hn::Add(yy, zz));
    const auto two_k2 = hn::Add(k2, k2);
    e.value = hn::MulAdd(weight, k0, e.value);
    e.value = hn::Add(e.value, hn::MulAdd(k1, trace, hn::Mul(two_k2, dqd)));
    const auto w1 = hn::Mul(weight, k1), w2 = hn::Mul(weight, two_k2);
    e.x = hn::MulAdd(w1, dx, e.x);
    e.y = hn::MulAdd(w1, dy, e.y);
    e.z = hn::MulAdd(w1, dz, e.z);
    e.isotropic = hn::Add(e.isotropic, w1);
    const auto w2x = hn::Mul(w2, dx), w2y = hn::Mul(w2, dy), w2z = hn::Mul(w2, dz);
    e.xx = hn::MulAdd(w2x, dx, e.xx);
    e.yy = hn::MulAdd(w2y, dy, e.yy);
    e.zz = hn::MulAdd(w2z, dz, e.zz);
    e.xy = hn::MulAdd(w2x, dy, e.xy);
    e.xz = hn::MulAdd(w2x, dz, e.xz);
    e.yz = hn::MulAdd(w2y, dz, e.yz);
}

/// An Expansion with its partial sums added up.
struct Polynomial {
    Vec3 center;
    float value, x, y, z, xx, yy, zz, xy, xz, yz;

    HWY_INLINE Polynomial(const Expansion& e, Vec3 about) : center(about) {
        if (e.nodes == 0) {  // often so for packets of many points a pixel
            value = x = y = z = xx = yy = zz = xy = xz = yz = 0;
            return;
        }
        const Nodes d;
        value = total(d, e.value);
        x = 2 * total(d, e.x), y = 2 * total(d, e.y), z = 2 * total(d, e.z);
        const float isotropic = total(d, e.isotropic);
        xx = isotropic + total(d, e.xx), yy = isotropic + total(d, e.yy);
        zz = isotropic + total(d, e.zz);
        xy = 2 * total(d, e.xy), xz = 2 * total(d, e.xz), yz = 2 * total(d, e.yz);
    }

    HWY_INLINE PointVector at(PointVector px, PointVector py, PointVector pz) const {
        const Points d;
        const auto ax = hn::Sub(px, hn::Set(d, center.x)), ay = hn::Sub(py, hn::Set(d, center.y)),
                   az = hn::Sub(pz, hn::Set(d, center.z));
        const auto of_x = hn::MulAdd(
            hn::Set(d, xx), ax,
            hn::MulAdd(hn::Set(d, xy), ay, hn::MulAdd(hn::Set(d, xz), az, hn::Set(d, x))));
        const auto of_y =
            hn::MulAdd(hn::Set(d, yy), ay, hn::MulAdd(hn::Set(d, yz), az, hn::Set(d, y)));
        const auto of_z = hn::MulAdd(hn::Set(d, zz), az, hn::Set(d, z));
        return hn::MulAdd(of_x, ax, hn::MulAdd(of_y, ay, hn::MulAdd(of_z, az, hn::Set(d, value))));
    }
};

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
        // Not CompressStore: to memory, some processors compress hundreds of times slower.
        const auto mask = hn::RebindMask(d, chosen);
        hn::StoreU(hn::Compress(values, mask), d, storage_.data() + size_);
        size_ += hn::CountTrue(d, mask);
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
