// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.h"

namespace tallow {

/// Samples of a surface: positions [mm], unit normals and exact areas [mm^2], one item a sample.
struct SampledSurface {
    std::span<const Vec3> position;
    std::span<const Vec3> normal;
    std::span<const float> area;

    std::size_t size() const { return position.size(); }
};

/// A symmetric matrix.
struct Symmetric {
    float xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

    float trace() const { return xx + yy + zz; }
    Symmetric& operator+=(const Symmetric& b) {
        xx += b.xx, yy += b.yy, zz += b.zz, xy += b.xy, xz += b.xz, yz += b.yz;
        return *this;
    }
    friend Symmetric operator*(float s, const Symmetric& m) {
        return {s * m.xx, s * m.yy, s * m.zz, s * m.xy, s * m.xz, s * m.yz};
    }
};

/// (u v^T + v u^T) / 2.
inline Symmetric symmetric_product(Vec3 u, Vec3 v) {
    return {u.x * v.x,
            u.y * v.y,
            u.z * v.z,
            0.5f * (u.x * v.y + u.y * v.x),
            0.5f * (u.x * v.z + u.z * v.x),
            0.5f * (u.y * v.z + u.z * v.y)};
}

/// A piece of surface and its moments about its centroid c: what it looks like from afar.
struct SurfacePatch {
    static constexpr std::uint32_t kNone = ~std::uint32_t(0);

    Vec3 centroid{0};                  // mm, weighted by area
    float area = 0;                    // mm^2
    Vec3 vector_area{0};               // mm^2, integral of n
    float radius = 0;                  // mm, of a disc that spreads its area as far
    Symmetric second;                  // mm^4, integral of (y - c) (y - c)^T
    Symmetric vector_first;            // mm^3, integral of n (y - c)^T, its symmetric part
    std::uint32_t begin = 0, end = 0;  // its samples in PatchTree::order
    std::uint32_t child = kNone;       // its halves are that patch and the next
    bool edge = false;                 // its normals differ so much that it must not act as one
};

/// A closed surface, halved over and over: into parts of equal numbers of samples along the widest
/// axis, and where a part is small but its normals differ much, into those that face this way and
/// that, so that the two sides of an edge or of a thin sheet come apart.
struct PatchTree {
    std::vector<std::uint32_t> order;   // samples, those of a patch side by side
    std::vector<SurfacePatch> patches;  // the root first, parents before children
    std::vector<std::uint32_t> fine;    // patches of at most `largest_area` without edges, in order
    double area = 0;                    // mm^2, of all

    std::span<const std::uint32_t> samples(const SurfacePatch& patch) const {
        return std::span(order).subspan(patch.begin, patch.end - patch.begin);
    }
};

/// Halves patches until they hold few samples. The same for any number of threads.
PatchTree build_patch_tree(const SampledSurface& samples, double largest_area);

}  // namespace tallow
