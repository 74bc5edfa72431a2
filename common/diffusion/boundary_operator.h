// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "common/diffusion/boundary_sum.h"
#include "common/diffusion/surface_clusters.h"

namespace tallow {

/// The integral equation of diffusion inside a closed surface, on clusters, in three channels:
///
///     sum_j a_j k_ij (phi_i - (1 + s rho) e^(-s rho) phi_j)
///         + sum_j a_j e^(-s rho) phi_j / (8 pi A D rho) = S_i
///     k_ij = n_j . (y_j - x_i) / (4 pi rho^3),   rho = |y_j - x_i|
///
/// x_i is the cluster's position. The surface is integrated patch by patch, each as small as its
/// distance asks for: coefficients of clusters that are near are kept, and many far ones act
/// together, by moments of phi on them. docs/BODY_AWARE.md derives it.
class BoundaryOperator {
public:
    /// Time and memory grow as N log N with the number of clusters.
    BoundaryOperator(const SampledSurface& samples, const PatchTree& tree,
                     const SurfaceClusters& clusters,
                     const std::array<ChannelDiffusion, 3>& channels);

    struct Solution {
        std::vector<double> phi;  // [cluster] fluence, W/mm^2
        int iterations = 0;
        bool converged = false;
    };
    /// GMRES from `guess` until a tenth of the residual changes the exitance phi / (2 A) by less
    /// than `tolerance` (root mean square of the change over that of the exitance).
    Solution solve(int channel, const std::vector<double>& source, const std::vector<double>& guess,
                   double tolerance) const;

    /// The left side of the equation: result[cluster] of phi[cluster].
    void multiply(int channel, std::span<const float> phi, std::span<float> result) const;

    /// The integrals of the equation's left side at `points` that are no clusters, of phi[cluster];
    /// `samples` and `tree` are those of the constructor.
    std::vector<SurfaceSum> sum_layers(const SampledSurface& samples, const PatchTree& tree,
                                       int channel, std::span<const float> phi,
                                       std::span<const PointPacket> points) const;

    std::size_t memory_bytes() const;

private:
    /// A patch above the clusters: its halves are others, further on, or clusters.
    struct Parent {
        Vec3 centroid;
        std::array<std::uint32_t, 2> half;
        std::array<bool, 2> is_cluster;
    };
    void number_parents(const PatchTree& tree);
    void lift(int channel, std::span<const float> phi, std::vector<FluencePatch>& patches) const;

    std::array<float, 3> s_, single_layer_;              // [channel], see BoundarySurface
    std::vector<std::uint32_t> cluster_of_, parent_of_;  // [patch] or SurfacePatch::kNone
    std::vector<SurfacePatch> clusters_;
    std::vector<Parent> parents_;
    std::vector<BoundaryPacket> packets_;
};

}  // namespace tallow
