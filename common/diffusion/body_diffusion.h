// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "common/cloud/point_octree.h"
#include "common/diffusion/boundary_operator.h"
#include "common/diffusion/cluster_field.h"
#include "common/diffusion/surface_clusters.h"
#include "common/optics/medium.h"

namespace tallow {

/// The way of light that enters at a sample, until it scatters: straight on along w_i for `length`
/// mm, and then for a share `reflected` of it along `w`, mirrored inside the surface.
struct Beam {
    float length;
    float reflected;
    Vec3 w;  // unit
};

/// Light that enters a body at samples of its surface, and the tree over them.
struct EnteringLight {
    std::span<const Vec3> position;        // [sample] mm
    std::span<const Vec3> normal;          // [sample] unit, outward
    std::span<const Vec3> w_i;             // [sample] mean direction of travel inside
    std::span<const Rgb> E_t;              // [sample] transmitted irradiance, W/mm^2
    std::span<const float> area;           // [sample] mm^2
    std::span<const Beam> beams;           // [sample]
    std::span<const std::uint32_t> index;  // [sample] in the SampledSurface
    std::span<const OctreeNode> nodes;
};

/// Diffusion in the body itself, beside that in the half-space that profiles stand for.
///
/// Light that entered scatters first along its refracted beam: sources at a few depths there. Their
/// diffuse fluence on the true surface gives the exitance B = phi / (2 A); the same sources in a
/// half-space give Hs. A profile's exitance times B / Hs is that of the body.
///
/// Source   docs/BODY_AWARE.md.
class BodyDiffusion {
public:
    /// Clusters and operators, for any light. `samples` are all of the closed surface. `images`
    /// [channel] is the share of image sources in the half-space that the profile stands for; the
    /// rest of it has the boundary condition of the body.
    BodyDiffusion(const SampledSurface& samples, const Medium& medium, Rgb images,
                  std::size_t clusters);

    /// Depth along a beam beyond which no source lies, mm.
    static float deepest_source(const Medium& medium);

    struct Solution {
        std::vector<Rgb> B, Hs;  // [cluster] W/mm^2, >= 0
        int iterations = 0;      // of GMRES, the most of any channel
        bool converged = true;
    };
    Solution solve(const EnteringLight& light) const;

    const SurfaceClusters& clusters() const { return clusters_; }

private:
    Medium medium_;
    Rgb images_;
    PatchTree tree_;
    SurfaceClusters clusters_;
    std::array<ChannelDiffusion, 3> channels_;
    std::optional<BoundaryOperator> operator_;
};

}  // namespace tallow
