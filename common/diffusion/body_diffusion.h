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

/// Light that enters a body at samples of its surface, and the tree over them.
struct EnteringLight {
    std::span<const Vec3> position;  // [sample] mm
    std::span<const Vec3> normal;    // [sample] unit, outward
    std::span<const Vec3> w_i;       // [sample] mean direction of travel inside
    std::span<const Rgb> E_t;        // [sample] transmitted irradiance, W/mm^2
    std::span<const float> area;     // [sample] mm^2
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
    /// Clusters and operators, for any light. `samples` are all of the closed surface.
    BodyDiffusion(const SampledSurface& samples, const Medium& medium, std::size_t clusters);

    struct Report {
        std::size_t clusters = 0;
        int iterations = 0;  // the most of any channel
        bool converged = true;
    };
    /// B / Hs for some light.
    ClusterRatio solve(const EnteringLight& light, Report& report) const;

private:
    Medium medium_;
    SurfaceClusters clusters_;
    std::array<ChannelDiffusion, 3> channels_;
    std::array<std::optional<BoundaryOperator>, 3> operators_;
};

}  // namespace tallow
