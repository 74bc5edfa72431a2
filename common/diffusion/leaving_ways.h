// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/diffusion/boundary_operator.h"
#include "common/diffusion/flight.h"
#include "common/diffusion/leaving_once.h"
#include "common/diffusion/leaving_radiance.h"
#include "common/diffusion/source_sums.h"
#include "common/optics/medium.h"

namespace tallow {

/// One channel of a solved body, at clusters of its surface.
struct SolvedChannel {
    const SourceSums& sources;
    const SourceKernels& kernels;
    const BoundaryOperator& equation;
    const SampledSurface& samples;
    const PatchTree& tree;
    std::span<const double> S;                 // [cluster] fluence by the sources alone, W/mm^2
    std::span<const double> phi;               // [cluster] fluence, W/mm^2
    std::span<const std::int64_t> own_sample;  // [cluster] as SourceSums has it
    int channel;
};

/// The ways on which light leaves the clusters of a body, followed back from them: what scatters on
/// them for the last time leaves.
///
/// Source   docs/BODY_AWARE.md.
class LeavingWays {
public:
    /// Light that comes from farther than `longest` mm does not matter.
    LeavingWays(std::span<const Vec3> positions, std::span<const Vec3> normals,
                const FollowFlights& follow, float longest);

    /// [cluster] with how far the body reaches behind it.
    std::vector<LeavingPlace> places() const;

    /// [cluster] what leaves of the fluence inside, of light that scattered twice or more:
    ///
    ///     X(w') = alpha' / (4 eta^2) 2 integral of F_t mu * integral over u of phi(x - u w') e^-u
    ///     du
    std::vector<LeavingRadiance> radiance(const SolvedChannel& solved) const;

    /// The same of a fluence that is 1 everywhere, but for the factor; of a small one where no way
    /// has any length, so that light leaves evenly there.
    LeavingRadiance of_even_fluence(std::size_t cluster, double mean_free_path) const;

private:
    static constexpr std::size_t kDirections = LeavingRays::kDirections;
    static constexpr std::size_t kNodes = LeavingRays::kNodes;

    /// Where light scatters last, on the ways of one cluster.
    struct Nodes {
        std::array<std::array<Vec3, kNodes>, kDirections> place;
        std::array<std::array<float, kNodes>, kDirections> distance;  // mm, from the cluster
        std::array<double, kDirections> probability;                  // that any does on the way
    };
    using Fluence = std::array<std::array<double, kNodes>, kDirections>;

    Collisions collisions(std::size_t cluster, std::size_t direction, double mean_free_path) const;
    std::vector<Nodes> place_nodes(const DecayRule<kNodes>& rule, double mean_free_path) const;
    std::vector<Fluence> of_sources(const SolvedChannel& solved,
                                    std::span<const Nodes> nodes) const;
    std::vector<Fluence> of_layers(const SolvedChannel& solved, std::span<const Nodes> nodes) const;

    std::vector<Vec3> position_, normal_;  // [cluster]
    std::vector<Flight> back_;             // [cluster][direction]
    float longest_;
};

}  // namespace tallow
