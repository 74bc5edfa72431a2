// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/cloud/point_octree.h"
#include "common/diffusion/boundary_sum.h"
#include "common/diffusion/flight.h"
#include "common/diffusion/layered_nodes.h"
#include "common/diffusion/leaving_once.h"
#include "common/diffusion/light_balance.h"
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
    /// [sample] part of E_t whose light is wanted also where it leaves after one scattering, for
    /// that is not computed elsewhere. Empty: none of it.
    std::span<const Rgb> first_order{};
};

/// How sources act, by the square of the distance [mm^2], in one channel of a medium.
///
/// in_infinite_medium   e^(-s d) / d
/// inside               alpha' e^(-s d) / d + D e^(-sigma_t' d) / d^2: Grosjean's two parts, light
///                      that has scattered once more, and light that is on its way to
/// leaving              what leaves of a half-space by the balance of light, all depths of sources
///                      together: the counterpart of what `inside` and the layers are for a body
struct SourceKernels {
    /// Out to `range` mm.
    SourceKernels(const ReducedChannel& of, const ChannelDiffusion& channel,
                  const LightBalance& balance, double range);

    ReducedChannel reduced;
    double unit;                  // mm
    double kappa;                 // decay of light deep inside, 1 / mean free path
    DecayRule<5> depths;          // of sources along a flight
    std::array<double, 5> depth;  // the same on a way without end, mean free paths
    double factor;                // of all kernels: alpha' / (4 pi D)
    KernelTable in_infinite_medium, inside, leaving;
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

    /// Exitance of light that scattered once, see LeavingOnce: all of it, and what is wanted.
    std::vector<LeavingOnce::Exitance> leaving_once(std::span<const LeavingPlace> places) const;

    /// H: exitance of the half-space that has these sources.
    std::vector<double> leaving_half_space(std::span<const Vec3> places,
                                           std::span<const std::int64_t> own_sample) const;

private:
    struct Sources {
        LayeredNodes nodes;
        PointSum sum;
    };
    std::vector<float> first_order_on_flights() const;
    template <class Add>
    void put_on_flight(std::size_t i, const Add& add) const;
    template <class Add>
    void put_on_surface(std::size_t i, const Add& add) const;
    template <class Put>
    Sources make_sources(const KernelTable& kernel, std::uint32_t layers, const Put& put) const;
    std::vector<double> sum(const Sources& sources, const KernelTable& kernel,
                            std::span<const Vec3> places,
                            std::span<const std::int64_t> own_sample) const;
    double own_cell(const Sources& sources, const KernelTable& kernel, Vec3 place,
                    std::size_t sample) const;

    const EnteringLight& light_;
    const SourceKernels& kernels_;
    double mfp_;
    int c_;
    Sources on_flights_, on_surface_;
};

}  // namespace tallow
