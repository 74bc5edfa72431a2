// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "common/base/rgb.h"
#include "common/base/vec.h"

namespace tallow {

/// One node of a linear octree over points in Morton order, stored depth first: the first child of
/// node i is i + 1, its next sibling is i + skip, the root is node 0. A leaf has skip 1.
///
/// A node owns the points [first, first + count). Children partition their parent's points in
/// order. Topology only: fluxes and moments depend on light groups and media, and are computed
/// where they are needed, in one linear pass.
struct OctreeNode {
    std::uint32_t first;
    std::uint32_t count;
    std::uint32_t skip;

    bool operator==(const OctreeNode&) const = default;
};

/// Points in a leaf at most, unless they coincide to the last bit of the Morton code.
/// Chosen, not tuned.
inline constexpr std::uint32_t kLeafSize = 8;

/// Bits per axis of the Morton code, and so the greatest depth of a tree.
inline constexpr int kMortonBits = 21;

/// The light of one light group on the samples of one body, its group scale not applied.
struct GroupIrradianceView {
    std::span<const Rgb> E_t;   // [sample] transmitted irradiance, W/mm^2
    std::span<const Vec3> w_i;  // [sample] mean direction in which the light travels just inside
                                // the surface, weighted by the channel mean of E_t; length <= 1;
                                // zero where E_t is zero
};

}  // namespace tallow
