// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/cloud/point_octree.h"
#include "common/diffusion/boundary_sum.h"
#include "common/diffusion/flight.h"
#include "common/nbody/point_sum.h"
#include "common/optics/diffusion.h"

namespace tallow {

/// Light that enters a body at samples of its surface, and the tree over them.
struct EnteringLight {
    std::span<const Vec3> position;        // [sample] mm
    std::span<const Vec3> normal;          // [sample] unit, outward
    std::span<const Vec3> w_i;             // [sample] mean direction of travel inside
    std::span<const Rgb> E_t;              // [sample] transmitted irradiance, W/mm^2
    std::span<const float> area;           // [sample] mm^2
    std::span<const Flight> flights;       // [sample] until it scatters, along w_i at first
    std::span<const std::uint32_t> index;  // [sample] in the SampledSurface
    std::span<const OctreeNode> nodes;
};

/// How sources act, by the square of the distance [mm^2], in one channel of a medium.
///
/// in_infinite_medium   e^(-s d) / d
/// inside               alpha' e^(-s d) / d + D e^(-sigma_t' d) / d^2: Grosjean's two parts, light
///                      that has scattered once more, and light that is on its way to
/// on_its_way           the second part of `inside` alone
/// leaving              what leaves of `inside` in a half-space, all depths of sources together
/// leaving_diffusion    what diffusion lets leave in a half-space, phi / (2 A)
/// on_its_way_out       on_its_way above the surface of a half-space, by LightBalance::kAbove
struct SourceKernels {
    /// Out to `range` mm.
    SourceKernels(const ReducedChannel& reduced, const ChannelDiffusion& channel, double range);

    double unit;          // mm
    double kappa;         // decay of light deep inside, 1 / mean free path
    DecayRule<5> depths;  // of sources along a flight
    double factor;        // of all kernels: alpha' / (4 pi D)
    KernelTable in_infinite_medium, inside, on_its_way, leaving, leaving_diffusion, on_its_way_out;
};

/// What light does from where it scatters first, at a few depths along its refracted beams, in one
/// channel: sums over the samples.
///
/// Source   docs/BODY_AWARE.md.
class SourceSums {
public:
    SourceSums(const EnteringLight& light, const SourceKernels& kernels, double mean_free_path,
               int c);

    /// S: diffuse fluence that the sources would have in an infinite medium, at places of the
    /// surface. `own_sample` [place] is the sample in the light that the place is of, or -1.
    std::vector<double> in_infinite_medium(std::span<const Vec3> places,
                                           std::span<const std::int64_t> own_sample) const;

    /// The same at points inside, of light that is to scatter for the last time.
    std::vector<double> inside(std::span<const Vec3> points,
                               std::span<const std::int64_t> own_sample) const;

    /// Fluence of light that scattered once and is on its way, above places of the surface, as if
    /// the medium went on there.
    std::vector<double> on_its_way_out(std::span<const Vec3> places,
                                       std::span<const Vec3> normals) const;

    /// H: exitance of the half-space that has these sources, of light that scattered twice or more;
    /// what `inside` and the layers are for a body.
    std::vector<double> leaving_half_space(std::span<const Vec3> places,
                                           std::span<const std::int64_t> own_sample) const;

    /// What `in_infinite_medium` and the boundary condition make of the half-space with these
    /// sources: the exitance of all that scattered.
    std::vector<double> diffusion_leaving_half_space(
        std::span<const Vec3> places, std::span<const std::int64_t> own_sample) const;

    /// on_its_way_out() of the half-space.
    std::vector<double> on_its_way_out_of_half_space(
        std::span<const Vec3> places, std::span<const std::int64_t> own_sample) const;

private:
    /// Where the light of a sample acts, and how much of it.
    struct Source {
        Vec3 offset;  // from the sample, mm
        float share;
    };
    Source on_flight(std::size_t i, std::size_t depth) const;
    Source on_surface(std::size_t i) const;
    std::vector<double> on_flights(const KernelTable& kernel, std::span<const Vec3> places,
                                   std::span<const std::int64_t> own_sample) const;
    std::vector<double> on_surface(const KernelTable& kernel, std::span<const Vec3> places,
                                   std::span<const std::int64_t> own_sample) const;
    template <class SourceOf>
    PointSum sources(const KernelTable& kernel, std::size_t sources, const SourceOf& source) const;
    template <class SourceOf>
    std::vector<double> sum(const PointSum& point_sum, std::span<const Vec3> places,
                            std::span<const std::int64_t> own_sample, std::size_t sources,
                            const SourceOf& source) const;
    template <class SourceOf>
    double own_cell(Vec3 place, std::size_t sample, const KernelTable& kernel, std::size_t sources,
                    const SourceOf& source) const;

    const EnteringLight& light_;
    const SourceKernels& kernels_;
    double mfp_;
    int c_;
    PointSum on_flights_, on_surface_;
};

}  // namespace tallow
