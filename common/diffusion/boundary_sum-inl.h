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

/// A patch acts as one on points farther away than its radius / opening.
struct Openings {
    float far;   // of patches above the clusters
    float part;  // of clusters and their parts, which are flat and have one more moment
};

// Measured: docs/BODY_AWARE.md has phi's error against an operator of samples alone.
constexpr Openings kOpenings{0.12f, 0.25f};

// The same for sums at points inside, which need not be solved with.
constexpr Openings kOpeningsInside{0.18f, 0.4f};

// Of a patch whose light has decayed by e to this power no channel sees more than the solid angle.
constexpr float kDarkExponent = 16;

constexpr float kInv4Pi = float(1 / (4 * std::numbers::pi));

/// From the points of a packet, some lanes of it, to a place.
struct Way {
    RowVector dx, dy, dz, u;  // u = rho^2

    HWY_INLINE Way(const PointPacket& packet, std::size_t lane, Vec3 to) {
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

/// g0, g1, g2 of FluencePatch, and g3 = (15 + 15 t + 6 t^2 + t^3) e^-t / rho^7 after them.
struct Decay {
    RowVector g0, g1, g2, g3;

    HWY_INLINE Decay(float s, RowVector u) : Decay(s, u, inverse_root(u)) {}
    HWY_INLINE Decay(float s, RowVector u, RowVector inverse) {
        const Rows d;
        const auto one = hn::Set(d, 1), three = hn::Set(d, 3);
        const auto inverse2 = hn::Mul(inverse, inverse);
        g0 = inverse;
        auto third = hn::Set(d, 15), second = three, first = one;
        if (s > 0) {
            const auto t = hn::Mul(hn::Set(d, s), hn::Mul(u, inverse));
            // Smaller ones would underflow, and are not seen anyway.
            g0 = hn::Mul(inverse, hn::Exp(d, hn::Max(hn::Neg(t), hn::Set(d, -80))));
            first = hn::Add(one, t);
            second = hn::MulAdd(t, hn::Add(three, t), three);
            third = hn::MulAdd(t, hn::MulAdd(t, hn::Add(hn::Set(d, 6), t), hn::Set(d, 15)),
                               hn::Set(d, 15));
        }
        const auto g0_2 = hn::Mul(g0, inverse2);
        g1 = hn::Mul(first, g0_2);
        const auto g0_4 = hn::Mul(g0_2, inverse2);
        g2 = hn::Mul(second, g0_4);
        g3 = hn::Mul(third, hn::Mul(g0_4, inverse2));
    }
    static HWY_INLINE RowVector inverse_root(RowVector u) {
        return hn::Div(hn::Set(Rows(), 1), hn::Sqrt(u));
    }
};

HWY_INLINE float least_distance2(const PointPacket& packet, Vec3 to) {
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

/// Goes down the tree until patches are small for their distance from a packet, and shows `sink`
/// patches above the clusters, parts of clusters, and single samples.
template <class Sink>
class PatchWalk {
public:
    PatchWalk(const BoundarySurface& surface, const PointPacket& points, const Openings& openings,
              Sink& sink)
        : surface_(surface), points_(points), openings_(openings), sink_(sink) {}

    void run() { visit(0, surface_.cluster_of[0]); }

private:
    // `cluster` is that which the patch is part of, if any.
    void visit(std::uint32_t index, std::uint32_t cluster) {
        const SurfacePatch& patch = surface_.tree.patches[index];
        if (cluster == SurfacePatch::kNone) cluster = surface_.cluster_of[index];
        const float least = std::sqrt(least_distance2(points_, patch.centroid));
        const bool is_far = cluster == SurfacePatch::kNone;
        if (patch.radius <= (is_far ? openings_.far : openings_.part) * least) {
            if (is_far)
                sink_.add_far(index, patch, least);
            else
                sink_.add_patch(patch, cluster);
        } else if (patch.child != SurfacePatch::kNone) {
            visit(patch.child, cluster);
            visit(patch.child + 1, cluster);
        } else {
            for (const std::uint32_t s : surface_.tree.samples(patch)) sink_.add_sample(s, cluster);
        }
    }

    const BoundarySurface& surface_;
    const PointPacket& points_;
    Openings openings_;
    Sink& sink_;
};

/// Integral of k over a far patch.
HWY_INLINE RowVector patch_solid_angle(const SurfacePatch& patch, const Way& way, const Decay& g) {
    const Rows d;
    const auto flux = hn::Add(way.dot(patch.vector_area), hn::Set(d, patch.vector_first.trace()));
    const auto k = hn::NegMulAdd(way.quadratic(patch.vector_first), g.g2, hn::Mul(flux, g.g1));
    return hn::Mul(hn::Set(d, kInv4Pi), k);
}

/// Both layers of fluence 1 on a part of a cluster, in any channel. Its double layer has second
/// moments too, as a flat patch has them:
///
///     V / area . d (g3 d^T S d - g2 tr S) / 2
struct PatchLayers {
    RowVector of_second, of_vector, flux, tilt;
    float area, half_trace;

    HWY_INLINE PatchLayers(const SurfacePatch& patch, const Way& way)
        : of_second(hn::Mul(hn::Set(Rows(), 0.5f), way.quadratic(patch.second))),
          of_vector(way.quadratic(patch.vector_first)),
          area(patch.area),
          half_trace(0.5f * patch.second.trace()) {
        const Rows d;
        const auto of_area = way.dot(patch.vector_area);
        flux = hn::Add(of_area, hn::Set(d, patch.vector_first.trace()));
        tilt = hn::Mul(of_area, hn::Set(d, 1 / area));
    }
    HWY_INLINE RowVector solid_angle(const Decay& g) const {
        return hn::Mul(hn::Set(Rows(), kInv4Pi), double_layer(g));
    }
    HWY_INLINE RowVector operator()(const Decay& g, float single_layer) const {
        const Rows d;
        const auto single =
            hn::MulAdd(hn::Set(d, area), g.g0,
                       hn::NegMulAdd(hn::Set(d, half_trace), g.g1, hn::Mul(of_second, g.g2)));
        return hn::NegMulAdd(hn::Set(d, kInv4Pi), double_layer(g),
                             hn::Mul(hn::Set(d, single_layer), single));
    }

private:
    HWY_INLINE RowVector double_layer(const Decay& g) const {
        const Rows d;
        const auto bend = hn::NegMulAdd(hn::Set(d, half_trace), g.g2, hn::Mul(of_second, g.g3));
        return hn::MulAdd(tilt, bend, hn::NegMulAdd(of_vector, g.g2, hn::Mul(flux, g.g1)));
    }
};

/// A sample as a point, but not nearer than makes its cell's single layer right as seen from its
/// center.
struct SampleLayers {
    RowVector u, inverse, k;
    float area;

    HWY_INLINE SampleLayers(const SampledSurface& samples, std::uint32_t s,
                            const PointPacket& points, std::size_t lane)
        : area(samples.area[s]) {
        const Rows d;
        const Way way(points, lane, samples.position[s]);
        u = hn::Max(way.u, hn::Set(d, area * kInv4Pi));
        inverse = Decay::inverse_root(u);
        k = hn::Mul(hn::Set(d, kInv4Pi), way.dot(area * samples.normal[s]));
    }
    HWY_INLINE RowVector solid_angle() const {
        return hn::Mul(k, hn::Mul(inverse, hn::Mul(inverse, inverse)));
    }
    HWY_INLINE RowVector operator()(float s, float single_layer) const {
        const Decay g(s, u, inverse);
        return hn::NegMulAdd(k, g.g1, hn::Mul(hn::Set(Rows(), single_layer * area), g.g0));
    }
};

/// A far patch with a fluence on it.
HWY_INLINE RowVector add_layers(const FluencePatch& patch, const PointPacket& points,
                                std::size_t lane, float s, RowVector sum) {
    const Rows d;
    const Way way(points, lane, patch.center);
    const Decay g(s, way.u);
    const auto flux = hn::Add(way.dot(patch.V), hn::Set(d, patch.M.trace()));
    sum = hn::MulAdd(hn::Set(d, patch.Q), g.g0, sum);
    sum = hn::NegMulAdd(flux, g.g1, sum);
    return hn::MulAdd(way.quadratic(patch.M), g.g2, sum);
}

/// Keeps the coefficients of a packet of clusters.
class PacketFiller {
public:
    PacketFiller(const BoundarySurface& surface, BoundaryPacket& packet)
        : surface_(surface), packet_(packet) {}

    void fill() {
        packet_.diagonal = {};
        PatchWalk(surface_, packet_, kOpenings, *this).run();
    }

    void add_far(std::uint32_t index, const SurfacePatch& patch, float least) {
        const Rows d;
        for (std::size_t i = 0; i < BoundaryPacket::kSize; i += hn::MaxLanes(d)) {
            const Way way(packet_, i, patch.centroid);
            add(packet_.diagonal.of + i, patch_solid_angle(patch, way, Decay(0, way.u)));
        }
        std::uint32_t channels = 0;
        for (int c = 0; c < 3; ++c)
            if (surface_.s[std::size_t(c)] * least < kDarkExponent) channels |= 1u << c;
        if (channels != 0) packet_.far.push_back({index, channels});
    }

    void add_patch(const SurfacePatch& patch, std::uint32_t cluster) {
        const Rows d;
        const std::size_t entry = entry_of(cluster);
        for (std::size_t i = 0; i < BoundaryPacket::kSize; i += hn::MaxLanes(d)) {
            const Way way(packet_, i, patch.centroid);
            const auto inverse = Decay::inverse_root(way.u);
            const PatchLayers layers(patch, way);
            add(packet_.diagonal.of + i, layers.solid_angle(Decay(0, way.u, inverse)));
            for (std::size_t c = 0; c < 3; ++c)
                add(packet_.coefficient[c][entry].of + i,
                    layers(Decay(surface_.s[c], way.u, inverse), surface_.single_layer[c]));
        }
    }

    void add_sample(std::uint32_t s, std::uint32_t cluster) {
        const Rows d;
        const std::size_t entry = entry_of(cluster);
        for (std::size_t i = 0; i < BoundaryPacket::kSize; i += hn::MaxLanes(d)) {
            const SampleLayers layers(surface_.samples, s, packet_, i);
            add(packet_.diagonal.of + i, layers.solid_angle());
            for (std::size_t c = 0; c < 3; ++c)
                add(packet_.coefficient[c][entry].of + i,
                    layers(surface_.s[c], surface_.single_layer[c]));
        }
    }

private:
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
            sum = add_layers(patches[far.patch], packet, i, s, sum);
        }
        hn::Store(sum, d, result.of + i);
    }
    for (std::uint32_t k = 0; k < packet.count; ++k)
        result.of[k] += packet.diagonal.of[k] * phi[packet.first + k];
}

/// Sums what a fluence on the surface does to points.
class LayerSummer {
public:
    LayerSummer(const BoundarySurface& surface, const SurfaceFluence& fluence,
                const PointPacket& points, SurfaceSum& result)
        : surface_(surface),
          fluence_(fluence),
          points_(points),
          s_(surface.s[std::size_t(fluence.channel)]),
          single_layer_(surface.single_layer[std::size_t(fluence.channel)]),
          result_(result) {}

    void sum() {
        result_ = {};
        PatchWalk(surface_, points_, kOpeningsInside, *this).run();
    }

    void add_far(std::uint32_t index, const SurfacePatch& patch, float least) {
        const Rows d;
        const FluencePatch& with_phi = fluence_.parents[fluence_.parent_of[index]];
        for (std::size_t i = 0; i < PointPacket::kSize; i += hn::MaxLanes(d)) {
            const Way way(points_, i, patch.centroid);
            add(result_.solid_angle.of + i, patch_solid_angle(patch, way, Decay(0, way.u)));
            if (s_ * least < kDarkExponent)
                add(result_.layers.of + i, add_layers(with_phi, points_, i, s_, hn::Zero(d)));
        }
    }

    void add_patch(const SurfacePatch& patch, std::uint32_t cluster) {
        const Rows d;
        const auto phi = hn::Set(d, fluence_.phi[cluster]);
        for (std::size_t i = 0; i < PointPacket::kSize; i += hn::MaxLanes(d)) {
            const Way way(points_, i, patch.centroid);
            const auto inverse = Decay::inverse_root(way.u);
            const PatchLayers layers(patch, way);
            add(result_.solid_angle.of + i, layers.solid_angle(Decay(0, way.u, inverse)));
            add(result_.layers.of + i,
                hn::Mul(phi, layers(Decay(s_, way.u, inverse), single_layer_)));
        }
    }

    void add_sample(std::uint32_t s, std::uint32_t cluster) {
        const Rows d;
        const auto phi = hn::Set(d, fluence_.phi[cluster]);
        for (std::size_t i = 0; i < PointPacket::kSize; i += hn::MaxLanes(d)) {
            const SampleLayers layers(surface_.samples, s, points_, i);
            add(result_.solid_angle.of + i, layers.solid_angle());
            add(result_.layers.of + i, hn::Mul(phi, layers(s_, single_layer_)));
        }
    }

private:
    const BoundarySurface& surface_;
    const SurfaceFluence& fluence_;
    const PointPacket& points_;
    float s_, single_layer_;
    SurfaceSum& result_;
};

void sum_layers(const BoundarySurface& surface, const SurfaceFluence& fluence,
                const PointPacket& points, SurfaceSum& result) {
    LayerSummer(surface, fluence, points, result).sum();
}

BoundarySumFunctions boundary_functions() { return {fill, multiply, sum_layers}; }

}  // namespace HWY_NAMESPACE
}  // namespace tallow
HWY_AFTER_NAMESPACE();

#endif
