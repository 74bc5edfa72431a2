// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/diffusion/patch_tree.h"

namespace tallow {

/// Diffusion in one channel, lengths in mm.
struct ChannelDiffusion {
    double D;  ///< mm
    double s;  ///< 1/mm, 0 without absorption
    double A;  ///< of the boundary condition phi = 2 A D dphi/dn (inward)
};

/// What the rows of a boundary operator are made from.
struct BoundarySurface {
    const SampledSurface& samples;
    const PatchTree& tree;
    std::span<const std::uint32_t> cluster_of;  // [patch] or SurfacePatch::kNone
    std::array<float, 3> s;                     // [channel] 1/mm
    std::array<float, 3> single_layer;          // [channel] 1 / (8 pi A D), 1/mm
};

/// Points that are near to each other, which share what is far from all of them.
struct PointPacket {
    static constexpr int kSize = 16;  // floats in the widest SIMD register there is

    struct alignas(64) Lanes {
        float of[kSize];
    };
    Lanes x, y, z;  // mm

    void set(int lane, Vec3 p) { x.of[lane] = p.x, y.of[lane] = p.y, z.of[lane] = p.z; }
};

/// Neighbouring clusters: rows of the operator. Lanes beyond `count` repeat the last one.
struct BoundaryPacket : PointPacket {
    struct Far {
        std::uint32_t patch;     // above the clusters
        std::uint32_t channels;  // bit c: the channel c sees it
    };

    std::uint32_t first = 0, count = 0;             // clusters
    Lanes diagonal;                                 // sum of all k
    std::vector<std::uint32_t> near;                // clusters whose coefficients are kept
    std::array<std::vector<Lanes>, 3> coefficient;  // [channel][near]
    std::vector<Far> far;
};

/// A patch with a fluence on it, and both of its layers, in one channel: with d from the point to
/// `center`, rho = |d|, t = s rho,
///
///     value = Q g0 - (V . d + tr M) g1 + d^T M d g2
///     g0 = e^-t / rho,   g1 = (1 + t) e^-t / rho^3,   g2 = (3 + 3 t + t^2) e^-t / rho^5
///
/// the Taylor series of the Green's function and its normal derivative to second degree in 1 / rho.
struct alignas(64) FluencePatch {
    Vec3 center{0};
    float Q = 0;
    Vec3 V{0};
    Symmetric M;
};

/// A fluence on the whole surface, of one channel.
struct SurfaceFluence {
    int channel;
    std::span<const float> phi;                // [cluster]
    std::span<const FluencePatch> parents;     // patches above the clusters
    std::span<const std::uint32_t> parent_of;  // [patch] its number among them
};

/// What the surface does to points anywhere.
struct SurfaceSum {
    PointPacket::Lanes layers;       // both layers of phi, as in a row of the operator
    PointPacket::Lanes solid_angle;  // sum of all a k: 1 inside, 0 outside
};

/// One instruction set's version of the work on a packet.
struct BoundarySumFunctions {
    /// Fills all of the packet that follows from its positions.
    void (*fill)(const BoundarySurface& surface, BoundaryPacket& packet);
    /// result[lane] = row times phi[cluster], of one channel; patches[patch] are those above the
    /// clusters with phi on them.
    void (*multiply)(const BoundaryPacket& packet, int channel, float s,
                     std::span<const FluencePatch> patches, std::span<const float> phi,
                     BoundaryPacket::Lanes& result);
    /// Both layers at points that are no clusters, without keeping coefficients.
    void (*sum_layers)(const BoundarySurface& surface, const SurfaceFluence& fluence,
                       const PointPacket& points, SurfaceSum& result);
};

/// The version for this machine's best instruction set.
const BoundarySumFunctions& boundary_sum_functions();

}  // namespace tallow
