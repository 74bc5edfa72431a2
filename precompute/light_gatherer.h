// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/base/rng.h"
#include "common/geometry/ray_scene.h"
#include "common/scene/scene.h"
#include "precompute/sample_surface.h"

namespace tallow {

/// What one light sends through the surface at one sample.
struct Transmitted {
    Rgb E_t;               // W/mm^2
    Vec3 direction{0.0f};  // sum over rays of mean(E_t) * direction of travel inside
};

/// Gathers one light after the other on stretches of neighbouring samples; one for each thread, for
/// the memory it keeps.
class LightGatherer {
public:
    LightGatherer(const Scene& scene, const RayScene& rays, const SurfaceSamples& samples,
                  float eta);

    /// Adds to result[i - begin] what the light sends to samples i in [begin, end), with
    /// `rays_per_sample` rays each. Sample i gets points [i, i + 1) * rays_per_sample of the
    /// sequence. A light that is_delta() needs one ray.
    void add(std::size_t light, int rays_per_sample, const Sobol2d& sequence, std::size_t begin,
             std::size_t end, std::span<Transmitted> result);

private:
    /// A ray towards a light with what it brings if nothing is in the way.
    struct Candidate {
        std::uint32_t sample;
        float cos_i;
        Rgb radiance;
    };

    void trace(std::size_t begin, float share, std::span<Transmitted> result);

    const Scene& scene_;
    const RayScene& rays_;
    const SurfaceSamples& samples_;
    float eta_;
    std::vector<Candidate> candidates_;
    std::vector<ShadowRay> shadow_rays_;  // [candidate]
    std::unique_ptr<bool[]> occluded_;    // [candidate]
};

}  // namespace tallow
