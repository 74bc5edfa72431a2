// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/cloud/point_octree.h"
#include "common/diffusion/boundary_sum.h"
#include "common/nbody/point_sum.h"
#include "common/optics/diffusion.h"

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

/// Depth along a beam beyond which no source lies, mean free paths.
double deepest_source_depth();

/// How sources act, by the square of the distance [mm^2], in one channel of a medium.
///
/// in_infinite_medium   e^(-s d) / d
/// inside               alpha' e^(-s d) / d + D e^(-sigma_t' d) / d^2: Grosjean's two parts, light
///                      that has scattered once more, and light that is on its way to
/// leaving              what leaves of the second in a half-space, all depths of sources together
struct SourceKernels {
    /// Out to `range` mm.
    SourceKernels(const ReducedChannel& reduced, const ChannelDiffusion& channel, double range);

    double unit;    // mm
    double factor;  // of all kernels: alpha' / (4 pi D)
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

    /// H: exitance of the half-space that has these sources, of light that scattered twice or more;
    /// what `inside` and the layers are for a body.
    std::vector<double> leaving_half_space(std::span<const Vec3> places,
                                           std::span<const std::int64_t> own_sample) const;

private:
    /// Where the light of a sample acts, and how much of it.
    struct Source {
        Vec3 offset;  // from the sample, mm
        float share;
    };
    Source on_beam(std::size_t i, std::size_t depth) const;
    Source on_surface(std::size_t i) const;
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
    PointSum on_beams_;
};

}  // namespace tallow
