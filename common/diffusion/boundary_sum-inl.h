// SPDX-License-Identifier: Apache-2.0
// Rows of the boundary operator, SIMD over the points of a packet, compiled once for every
// instruction set.
//
// Per-target include guard, as Highway asks for.
#if defined(TALLOW_BOUNDARY_SUM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TALLOW_BOUNDARY_SUM_INL_H
#undef TALLOW_BOUNDARY_SUM_INL_H
#else
#define TALLOW_BOUNDARY_SUM_INL_H
#endif

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/diffusion/boundary_sum.h"
#include "hwy/contrib/math/math-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace tallow {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Rows = hn::CappedTag<float, BoundaryPacket::kSize>;
using RowVector = hn::Vec<Rows>;

// A patch acts as one on points farther away than its radius / kOpening. Measured:
// docs/BODY_AWARE.md has phi's error against an operator of samples alone.
constexpr float kOpening = 0.12f;

// Of a patch whose light has decayed by e to this power no channel sees more than the solid angle.
constexpr float kDarkExponent = 16;

constexpr float kInv4Pi = float(1 / (4 * std::numbers::pi));

/// From the points of a packet, some lanes of it, to a place.
struct Way {
    RowVector dx, dy, dz, u;  // u = rho^2

    HWY_INLINE Way(const BoundaryPacket& packet, std::size_t lane, Vec3 to) {
        const Rows d;
        dx = hn::Sub(hn::Set(d, to.x), hn::Load(d, packet.x.of + lane));
        dy = hn::Sub(hn::Set(d, to.y), hn::Load(d, packet.y.of + lane));
        dz = hn::Sub(hn::Set(d, to.z), hn::Load(d, packet.z.of + lane));
        u = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
    }
    HWY_INLINE RowVector dot(Vec3 v) const {
        const Rows d;
        return hn::MulAdd(dx, hn::Set(d, v.x),
                          hn::MulAdd(dy, hn::Set(d, v.y), hn::Mul(dz, hn::Set(d, v.z))));
    }
    HWY_INLINE RowVector quadratic(const Symmetric& m) const {
        const Rows d;
        const auto of_x =
            hn::MulAdd(hn::Set(d, m.xx), dx,
                       hn::MulAdd(hn::Set(d, 2 * m.xy), dy, hn::Mul(hn::Set(d, 2 * m.xz), dz)));
        const auto of_y = hn::MulAdd(hn::Set(d, m.yy), dy, hn::Mul(hn::Set(d, 2 * m.yz), dz));
        return hn::MulAdd(of_x, dx,
                          hn::MulAdd(of_y, dy, hn::Mul(hn::Mul(hn::Set(d, m.zz), dz), dz)));
    }
};

/// g0, g1, g2 of FluencePatch.
struct Decay {
    RowVector g0, g1, g2;

    HWY_INLINE Decay(float s, RowVector u) : Decay(s, u, inverse_root(u)) {}
    HWY_INLINE Decay(float s, RowVector u, RowVector inverse) {
        const Rows d;
        const auto one = hn::Set(d, 1), three = hn::Set(d, 3);
        const auto inverse2 = hn::Mul(inverse, inverse);
        g0 = inverse;
        auto second = three, first = one;
        if (s > 0) {
            const auto t = hn::Mul(hn::Set(d, s), hn::Mul(u, inverse));
            // Smaller ones would underflow, and are not seen anyway.
            g0 = hn::Mul(inverse, hn::Exp(d, hn::Max(hn::Neg(t), hn::Set(d, -80))));
            first = hn::Add(one, t);
            second = hn::MulAdd(t, hn::Add(three, t), three);
        }
        const auto g0_2 = hn::Mul(g0, inverse2);
        g1 = hn::Mul(first, g0_2);
        g2 = hn::Mul(second, hn::Mul(g0_2, inverse2));
    }
    static HWY_INLINE RowVector inverse_root(RowVector u) {
        return hn::Div(hn::Set(Rows(), 1), hn::Sqrt(u));
    }
};

HWY_INLINE float least_distance2(const BoundaryPacket& packet, Vec3 to) {
    const Rows d;
    auto least = hn::Set(d, kInfinity);
    for (std::size_t i = 0; i < BoundaryPacket::kSize; i += hn::MaxLanes(d))
        least = hn::Min(least, Way(packet, i, to).u);
    return hn::GetLane(hn::MinOfLanes(d, least));
}

HWY_INLINE void add(float* to, RowVector value) {
    const Rows d;
    hn::Store(hn::Add(hn::Load(d, to), value), d, to);
}

/// Fills one packet: goes down the tree until patches are small for their distance.
class PacketFiller {
public:
    PacketFiller(const BoundarySurface& surface, BoundaryPacket& packet)
        : surface_(surface), packet_(packet) {}

    void fill() {
        packet_.diagonal = {};
        visit(0, surface_.cluster_of[0]);
    }

private:
    // `cluster` is that which the patch is part of, if any.
    void visit(std::uint32_t index, std::uint32_t cluster) {
        const SurfacePatch& patch = surface_.tree.patches[index];
        if (cluster == SurfacePatch::kNone) cluster = surface_.cluster_of[index];
        const float least = std::sqrt(least_distance2(packet_, patch.centroid));
        if (patch.radius <= kOpening * least) {
            if (cluster == SurfacePatch::kNone)
                add_far(index, patch, least);
            else
                add_patch(patch, cluster);
        } else if (patch.child != SurfacePatch::kNone) {
            visit(patch.child, cluster);
            visit(patch.child + 1, cluster);
        } else {
            for (const std::uint32_t s : surface_.tree.samples(patch)) add_sample(s, cluster);
        }
    }

    void add_far(std::uint32_t index, const SurfacePatch& patch, float least) {
        const Rows d;
        for (std::size_t i = 0; i < BoundaryPacket::kSize; i += hn::MaxLanes(d)) {
            const Way way(packet_, i, patch.centroid);
            add_to_diagonal(i, patch, way, Decay(0, way.u));
        }
        std::uint32_t channels = 0;
        for (int c = 0; c < 3; ++c)
            if (surface_.s[std::size_t(c)] * least < kDarkExponent) channels |= 1u << c;
        if (channels != 0) packet_.far.push_back({index, channels});
    }

    void add_patch(const SurfacePatch& patch, std::uint32_t cluster) {
        const Rows d;
        const std::size_t entry = entry_of(cluster);
        const float trace = patch.second.trace(), vector_trace = patch.vector_first.trace();
        for (std::size_t i = 0; i < BoundaryPacket::kSize; i += hn::MaxLanes(d)) {
            const Way way(packet_, i, patch.centroid);
            const auto inverse = Decay::inverse_root(way.u);
            add_to_diagonal(i, patch, way, Decay(0, way.u, inverse));
            const auto of_second = hn::Mul(hn::Set(d, 0.5f), way.quadratic(patch.second));
            const auto of_vector = way.quadratic(patch.vector_first);
            const auto flux = hn::Add(way.dot(patch.vector_area), hn::Set(d, vector_trace));
            for (std::size_t c = 0; c < 3; ++c) {
                const Decay g(surface_.s[c], way.u, inverse);
                const auto single = hn::MulAdd(
                    hn::Set(d, patch.area), g.g0,
                    hn::NegMulAdd(hn::Set(d, 0.5f * trace), g.g1, hn::Mul(of_second, g.g2)));
                const auto both = hn::NegMulAdd(flux, g.g1, hn::Mul(of_vector, g.g2));
                add(packet_.coefficient[c][entry].of + i,
                    hn::MulAdd(hn::Set(d, surface_.single_layer[c]), single,
                               hn::Mul(hn::Set(d, kInv4Pi), both)));
            }
        }
    }

    // A point, but not nearer than makes its cell's single layer right as seen from its center.
    void add_sample(std::uint32_t s, std::uint32_t cluster) {
        const Rows d;
        const std::size_t entry = entry_of(cluster);
        const float area = surface_.samples.area[s], least = area * kInv4Pi;
        const Vec3 vector_area = area * surface_.samples.normal[s];
        for (std::size_t i = 0; i < BoundaryPacket::kSize; i += hn::MaxLanes(d)) {
            Way way(packet_, i, surface_.samples.position[s]);
            way.u = hn::Max(way.u, hn::Set(d, least));
            const auto inverse = Decay::inverse_root(way.u);
            const auto k = hn::Mul(hn::Set(d, kInv4Pi), way.dot(vector_area));
            add(packet_.diagonal.of + i, hn::Mul(k, hn::Mul(inverse, hn::Mul(inverse, inverse))));
            for (std::size_t c = 0; c < 3; ++c) {
                const Decay g(surface_.s[c], way.u, inverse);
                add(packet_.coefficient[c][entry].of + i,
                    hn::NegMulAdd(k, g.g1,
                                  hn::Mul(hn::Set(d, surface_.single_layer[c] * area), g.g0)));
            }
        }
    }

    HWY_INLINE void add_to_diagonal(std::size_t lane, const SurfacePatch& patch, const Way& way,
                                    const Decay& g) {
        const Rows d;
        const auto flux =
            hn::Add(way.dot(patch.vector_area), hn::Set(d, patch.vector_first.trace()));
        const auto k = hn::NegMulAdd(way.quadratic(patch.vector_first), g.g2, hn::Mul(flux, g.g1));
        add(packet_.diagonal.of + lane, hn::Mul(hn::Set(d, kInv4Pi), k));
    }

    // Parts of a cluster come one after the other.
    std::size_t entry_of(std::uint32_t cluster) {
        if (packet_.near.empty() || packet_.near.back() != cluster) {
            packet_.near.push_back(cluster);
            for (auto& coefficients : packet_.coefficient) coefficients.push_back({});
        }
        return packet_.near.size() - 1;
    }

    const BoundarySurface& surface_;
    BoundaryPacket& packet_;
};

void fill(const BoundarySurface& surface, BoundaryPacket& packet) {
    PacketFiller(surface, packet).fill();
}

void multiply(const BoundaryPacket& packet, int channel, float s,
              std::span<const FluencePatch> patches, std::span<const float> phi,
              BoundaryPacket::Lanes& result) {
    const Rows d;
    const auto& coefficient = packet.coefficient[std::size_t(channel)];
    for (std::size_t i = 0; i < BoundaryPacket::kSize; i += hn::MaxLanes(d)) {
        auto sum = hn::Zero(d);
        for (std::size_t k = 0; k < packet.near.size(); ++k)
            sum = hn::MulAdd(hn::Load(d, coefficient[k].of + i), hn::Set(d, phi[packet.near[k]]),
                             sum);
        for (const BoundaryPacket::Far& far : packet.far) {
            if ((far.channels >> channel & 1) == 0) continue;
            const FluencePatch& patch = patches[far.patch];
            const Way way(packet, i, patch.center);
            const Decay g(s, way.u);
            const auto flux = hn::Add(way.dot(patch.V), hn::Set(d, patch.M.trace()));
            sum = hn::MulAdd(hn::Set(d, patch.Q), g.g0, sum);
            sum = hn::NegMulAdd(flux, g.g1, sum);
            sum = hn::MulAdd(way.quadratic(patch.M), g.g2, sum);
        }
        hn::Store(sum, d, result.of + i);
    }
    for (std::uint32_t k = 0; k < packet.count; ++k)
        result.of[k] += packet.diagonal.of[k] * phi[packet.first + k];
}

BoundarySumFunctions boundary_functions() { return {fill, multiply}; }

}  // namespace HWY_NAMESPACE
}  // namespace tallow
HWY_AFTER_NAMESPACE();

#endif
