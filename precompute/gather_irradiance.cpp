// SPDX-License-Identifier: Apache-2.0
// Samples -> transmitted irradiance. Shadow rays are gathered in blocks, one light at a time, so
// that the ray tracer gets bundles of similar rays.
#include "precompute/gather_irradiance.h"

#include <array>
#include <memory>

#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

constexpr std::size_t kBlock = 64;  // samples whose rays are traced together

/// A ray towards a light with what it brings if nothing is in the way.
struct Candidate {
    std::uint32_t sample;
    Rgb E_t;           // this ray's share of the transmitted irradiance
    Vec3 w_refracted;  // direction of travel inside
};

class BlockGatherer {
public:
    BlockGatherer(const Scene& scene, const RayScene& rays, const SurfaceSamples& samples,
                  float eta, std::vector<GroupIrradiance>& groups)
        : scene_(scene), rays_(rays), samples_(samples), eta_(eta), groups_(groups) {}

    void gather(std::size_t begin, std::size_t end) {
        for (std::size_t light = 0; light < scene_.lights.size(); ++light) {
            candidates_.clear();
            shadow_rays_.clear();
            for (std::size_t i = begin; i < end; ++i) collect(i, light);
            add_unoccluded(groups_[scene_.lights[light].group]);
        }
        for (GroupIrradiance& group : groups_)
            for (std::size_t i = begin; i < end; ++i) normalize_direction(group, i);
    }

private:
    void collect(std::size_t i, std::size_t light_index) {
        const Light& light = scene_.lights[light_index];
        const int count = is_delta(light) ? 1 : scene_.settings.light_samples;
        const std::uint64_t scramble = mix_bits(i * 0x9e3779b97f4a7c15ull + light_index);
        const Vec3 x = samples_.ray_origin[i], n = samples_.normal[i];
        for (int k = 0; k < count; ++k) {
            const auto sample = sample_light(light, x, n, sobol_2d(std::uint32_t(k), scramble));
            if (!sample) continue;
            const float cos_i = glm::dot(sample->w_i, n);
            if (cos_i <= 0) continue;
            const auto w_refracted = refract(sample->w_i, n, eta_);
            if (!w_refracted) continue;  // total reflection: the body is the thinner medium
            const Rgb E_t =
                sample->radiance * (fresnel_transmittance(eta_, cos_i) * cos_i / float(count));
            candidates_.push_back({std::uint32_t(i), E_t, *w_refracted});
            shadow_rays_.push_back({rays_.offset_origin(x, n, n), sample->w_i, sample->distance});
        }
    }

    void add_unoccluded(GroupIrradiance& group) {
        if (capacity_ < candidates_.size()) {
            capacity_ = candidates_.size();
            occluded_ = std::make_unique<bool[]>(capacity_);
        }
        rays_.occluded(shadow_rays_, {occluded_.get(), candidates_.size()});
        for (std::size_t k = 0; k < candidates_.size(); ++k) {
            if (occluded_[k]) continue;
            const Candidate& c = candidates_[k];
            group.E_t[c.sample] += c.E_t;
            group.w_i[c.sample] += mean(c.E_t) * c.w_refracted;
        }
    }

    static void normalize_direction(GroupIrradiance& group, std::size_t i) {
        const float weight = mean(group.E_t[i]);
        group.w_i[i] = weight > 0 ? group.w_i[i] / weight : Vec3(0);
    }

    const Scene& scene_;
    const RayScene& rays_;
    const SurfaceSamples& samples_;
    float eta_;
    std::vector<GroupIrradiance>& groups_;
    std::vector<Candidate> candidates_;
    std::vector<ShadowRay> shadow_rays_;
    std::unique_ptr<bool[]> occluded_;
    std::size_t capacity_ = 0;
};

}  // namespace

void gather_irradiance_range(const Scene& scene, const RayScene& rays,
                             const SurfaceSamples& samples, float eta, std::size_t first,
                             std::size_t last, std::vector<GroupIrradiance>& groups,
                             Progress& progress) {
    const std::size_t blocks = (last - first + kBlock - 1) / kBlock;
    parallel_ranges(blocks, 4, [&](std::size_t begin, std::size_t end) {
        BlockGatherer gatherer(scene, rays, samples, eta, groups);
        for (std::size_t block = begin; block < end; ++block)
            gatherer.gather(first + block * kBlock, std::min(last, first + (block + 1) * kBlock));
        progress.add(std::min(last, first + end * kBlock) - (first + begin * kBlock));
    });
}

std::vector<GroupIrradiance> gather_irradiance(const Scene& scene, const RayScene& rays,
                                               const SurfaceSamples& samples, float eta,
                                               Progress& progress) {
    std::vector<GroupIrradiance> groups(
        scene.groups.size(),
        {std::vector<Rgb>(samples.size(), Rgb(0)), std::vector<Vec3>(samples.size(), Vec3(0))});
    gather_irradiance_range(scene, rays, samples, eta, 0, samples.size(), groups, progress);
    return groups;
}

}  // namespace tallow
