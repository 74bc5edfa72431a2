// SPDX-License-Identifier: Apache-2.0
// Light and samples -> transmitted irradiance. What a ray brings is worked out only if nothing is
// in its way.
#include "precompute/light_gatherer.h"

#include "common/optics/fresnel.h"

namespace tallow {
namespace {

// Rays that are held until they are traced together. Chosen: they fit into the first-level cache.
constexpr std::size_t kPending = 256;

}  // namespace

LightGatherer::LightGatherer(const Scene& scene, const RayScene& rays,
                             const SurfaceSamples& samples, float eta)
    : scene_(scene),
      rays_(rays),
      samples_(samples),
      eta_(eta),
      occluded_(std::make_unique<bool[]>(kPending)) {
    candidates_.reserve(kPending);
    shadow_rays_.reserve(kPending);
}

void LightGatherer::add(std::size_t light, int rays_per_sample, const Sobol2d& sequence,
                        std::size_t begin, std::size_t end, std::span<Transmitted> result) {
    const float share = 1 / float(rays_per_sample);
    for (std::size_t i = begin; i < end; ++i) {
        const Vec3 x = samples_.ray_origin[i], n = samples_.normal[i];
        const Vec3 origin = rays_.offset_origin(x, n, n);
        const std::size_t first = i * std::size_t(rays_per_sample);
        for (int k = 0; k < rays_per_sample; ++k) {
            const Vec2 u = sequence(std::uint32_t(first + std::size_t(k)));
            const auto sample = sample_light(scene_.lights[light], x, n, u);
            if (!sample) continue;
            const float cos_i = glm::dot(sample->w_i, n);
            if (cos_i <= 0) continue;
            candidates_.push_back({std::uint32_t(i), cos_i, sample->radiance});
            shadow_rays_.push_back({origin, sample->w_i, sample->distance});
            if (candidates_.size() == kPending) trace(begin, share, result);
        }
    }
    trace(begin, share, result);
}

void LightGatherer::trace(std::size_t begin, float share, std::span<Transmitted> result) {
    rays_.occluded(shadow_rays_, {occluded_.get(), shadow_rays_.size()});
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
        if (occluded_[k]) continue;
        const Candidate& c = candidates_[k];
        const auto w_refracted =
            refract(shadow_rays_[k].direction, samples_.normal[c.sample], eta_);
        if (!w_refracted) continue;  // total reflection: the body is the thinner medium
        const Rgb E_t = c.radiance * (fresnel_transmittance(eta_, c.cos_i) * c.cos_i * share);
        Transmitted& sum = result[c.sample - begin];
        sum.E_t += E_t;
        sum.direction += mean(E_t) * *w_refracted;
    }
    candidates_.clear();
    shadow_rays_.clear();
}

}  // namespace tallow
