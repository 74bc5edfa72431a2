// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "common/diffusion/boundary_operator.h"
#include "common/diffusion/cluster_field.h"
#include "common/diffusion/flight.h"
#include "common/diffusion/leaving_radiance.h"
#include "common/diffusion/leaving_ways.h"
#include "common/diffusion/source_sums.h"
#include "common/diffusion/surface_clusters.h"
#include "common/optics/medium.h"

namespace tallow {

/// How many clusters a body gets: the fewest, but at least `least`, on which normals have a
/// variance of at most `variance`; at most about `most` anyway. See normal_variance().
struct ClusterWish {
    std::size_t least, most;
    double variance = 0;
};

/// Diffusion in the body itself, beside that in the half-space that profiles stand for.
///
/// Light that entered scatters first along its refracted beam: sources at a few depths there. Their
/// diffuse fluence on the true surface is solved for. From it follows the fluence inside, along the
/// ways on which light leaves: what scatters on them for the last time. In thin parts and at high
/// albedo the balance of light knows better how much that is: all that diffusion lets leave, less
/// what leaves after one scattering. H is the same for these sources in a half-space, over all
/// directions.
///
/// Source   docs/BODY_AWARE.md.
class BodyDiffusion {
public:
    /// Clusters and operators, for any light. `samples` are all of the closed surface, and what
    /// they point to must outlive this, and so must what `follow` refers to. Channels that are not
    /// `solved` get no fields.
    BodyDiffusion(const SampledSurface& samples, const Medium& medium, const ClusterWish& wish,
                  const FollowFlights& follow, std::array<bool, 3> solved = {true, true, true});

    /// How far flights have to be followed, mm.
    static float longest_flight(const Medium& medium);

    struct Fields {
        std::vector<Rgb> B;  // [cluster] phi / (2 A), W/mm^2, >= 0
        std::vector<Rgb> H;  // [cluster] exitance of the half-space, two scatterings and more, >= 0
    };
    /// Light that enters: its flux, and that times its cosine with the normal inside.
    struct Entry {
        std::vector<Rgb> E, E_mu;  // [fine cluster] W/mm^2
    };
    using ClusterRadiance = std::array<LeavingRadiance, 3>;  // [channel] two scatterings and more
    /// On the clusters, and on a quarter as many for an estimate of the error. Linear in the light:
    /// those of several lights may be added.
    struct Solution {
        Fields fine, coarse;
        std::vector<ClusterRadiance> radiance;  // [fine cluster] W/mm^2
        Entry entry;
        int iterations = 0;     // of GMRES, the most of any channel
        bool converged = true;  // GMRES did, and all is finite

        void add(Rgb scale, const Solution& b);
    };
    Solution solve(const EnteringLight& light) const;

    /// B / H between the clusters.
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
    const PatchTree& tree() const { return tree_; }
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
    Entry find_entry(const EnteringLight& light, std::span<const std::int64_t> lit) const;
    ChannelReport solve_channel(int c, const std::vector<double>& S, const std::vector<double>& H,
                                Solution& result, std::vector<double>& phi) const;
    void say_how_much(int c, std::span<const LeavingOnce::Exitance> leaving_once,
                      Solution& result) const;

    Medium medium_;
    std::array<bool, 3> solved_;
    SampledSurface samples_;
    PatchTree tree_;
    std::array<ChannelDiffusion, 3> channels_;
    std::array<std::optional<SourceKernels>, 3> kernels_;
    Level fine_, coarse_;
    std::optional<LeavingWays> ways_;    // from fine clusters
    std::vector<std::uint32_t> parent_;  // [fine cluster] the coarse one that holds it
};

}  // namespace tallow
