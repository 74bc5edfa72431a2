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

/// How many clusters a body gets: the fewest, but at least `least`, on which normals have a
/// variance of at most `variance`; at most about `most` anyway. See normal_variance().
struct ClusterWish {
    std::size_t least, most;
    double variance = 0;
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
    /// rest of it has the boundary condition of the body. Channels that are not `solved` get no
    /// fields, so that their ratio is 1.
    BodyDiffusion(const SampledSurface& samples, const Medium& medium, Rgb images,
                  const ClusterWish& wish, std::array<bool, 3> solved = {true, true, true});

    /// Depth along a beam beyond which no source lies, mm.
    static float deepest_source(const Medium& medium);

    struct Fields {
        std::vector<Rgb> B, Hs;  // [cluster] W/mm^2, >= 0
    };
    /// On the clusters, and on a quarter as many for an estimate of the error. Linear in the light:
    /// those of several lights may be added.
    struct Solution {
        Fields fine, coarse;
        int iterations = 0;     // of GMRES, the most of any channel
        bool converged = true;  // GMRES did, and all is finite

        void add(Rgb scale, const Solution& b);
    };
    Solution solve(const EnteringLight& light) const;

    /// B / Hs between the clusters.
    ClusterRatio ratio(const Solution& solution, Rgb strength = Rgb(1)) const;

    /// Estimated relRMSE of the exitance of all channels by the size of the clusters.
    ///
    ///     error = |M_N - M_n| / max(1, (N / n)^(2/3) - 1),   n clusters about N / 4
    ///
    /// that is, for an error that falls as N^(-2/3).
    /// Error    within a factor of two of the error against many more clusters (measured,
    ///          docs/BODY_AWARE.md); too small where n is nearly N, as with few samples.
    double estimate_error(const Solution& solution, Rgb strength = Rgb(1)) const;

    const SurfaceClusters& clusters() const { return fine_.clusters; }
    std::array<bool, 3> solved() const { return solved_; }
    /// Of the operators.
    std::size_t memory_bytes() const;

private:
    struct Level {
        SurfaceClusters clusters;
        std::optional<BoundaryOperator> equation;
    };
    struct ChannelReport {
        int iterations = 0;
        bool converged = true;
    };
    ChannelReport solve_channel(int c, const std::vector<double>& S, const std::vector<double>& Hs,
                                Solution& result) const;

    Medium medium_;
    Rgb images_;
    std::array<bool, 3> solved_;
    std::size_t samples_;
    std::array<ChannelDiffusion, 3> channels_;
    Level fine_, coarse_;
    std::vector<std::uint32_t> parent_;  // [fine cluster] the coarse one that holds it
};

}  // namespace tallow
