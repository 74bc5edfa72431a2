// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/diffusion/surface_clusters.h"

namespace tallow {

/// Diffusion in one channel, lengths in mm.
struct ChannelDiffusion {
    double D;  ///< mm
    double s;  ///< 1/mm, 0 without absorption
    double A;  ///< of the boundary condition phi = 2 A D dphi/dn (inward)
};

/// The integral equation of diffusion inside a closed surface, on clusters:
///
///     sum_j a_j k_ij (phi_i - (1 + s rho) e^(-s rho) phi_j)
///         + sum_j a_j e^(-s rho) phi_j / (8 pi A D rho) = S_i
///     k_ij = n_j . (y_j - x_i) / (4 pi rho^3),   rho = |y_j - x_i|
///
/// x_i is the cluster's position; where the cluster j is near, the integral over it runs over its
/// samples, rho at least half of their radius. docs/BODY_AWARE.md derives it.
class BoundaryOperator {
public:
    BoundaryOperator(const SampledSurface& samples, const SurfaceClusters& clusters,
                     const ChannelDiffusion& channel);

    struct Solution {
        std::vector<double> phi;  // [cluster] fluence, W/mm^2
        int iterations = 0;
        bool converged = false;
    };
    /// GMRES from `guess` until the exitance phi / (2 A) changes by less than `tolerance` of its
    /// mean (relRMSE) between one tenth of the residual and the next.
    Solution solve(const std::vector<double>& source, const std::vector<double>& guess,
                   double tolerance) const;

private:
    std::size_t n_;
    std::vector<float> matrix_;  // [row][column]
};

}  // namespace tallow
