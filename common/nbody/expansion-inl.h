// SPDX-License-Identifier: Apache-2.0
// Nodes of a tree, sixteen at a time: how far they are from a ball of points, and the polynomial
// that stands for them there. docs/EVALUATOR.md has the formulas and their bounds. Included once
// for every instruction set.
//
// Per-target include guard, as Highway asks for.
#if defined(TALLOW_EXPANSION_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TALLOW_EXPANSION_INL_H
#undef TALLOW_EXPANSION_INL_H
#else
#define TALLOW_EXPANSION_INL_H
#endif

#include "common/base/vec.h"
#include "common/nbody/group_sum.h"
#include "common/nbody/simd_kernel-inl.h"
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

}  // namespace HWY_NAMESPACE
}  // namespace tallow
HWY_AFTER_NAMESPACE();

#endif
