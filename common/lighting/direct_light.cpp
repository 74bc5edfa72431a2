// SPDX-License-Identifier: Apache-2.0
#include "common/lighting/direct_light.h"

#include <array>
#include <utility>

#include "common/base/rng.h"
#include "common/optics/fresnel.h"

namespace tallow {

float Acceptance::operator()(float cos_i) const {
    return eta == 1 ? 1.0f : fresnel_transmittance(eta, cos_i);
}

namespace {

// Rays of a receiver that are traced together.
constexpr std::size_t kBundle = 16;

/// Rays from a receiver towards one light, and what they bring if nothing is in the way.
class Bundle {
public:
    explicit Bundle(const RayScene& rays) : rays_(rays) {}

    void add(const ShadowRay& ray, Rgb brings) {
        ray_[count_] = ray;
        brings_[count_++] = brings;
        if (count_ == kBundle) trace();
    }

    Rgb finish() {
        trace();
        return std::exchange(sum_, Rgb(0));
    }

private:
    void trace() {
        if (count_ == 1)  // a packet with one ray takes half as long again
            occluded_[0] = rays_.occluded(ray_[0]);
        else
            rays_.occluded({ray_.data(), count_}, {occluded_.data(), count_});
        for (std::size_t i = 0; i < count_; ++i)
            if (!occluded_[i]) sum_ += brings_[i];
        count_ = 0;
    }

    const RayScene& rays_;
    std::array<ShadowRay, kBundle> ray_;
    std::array<Rgb, kBundle> brings_;
    std::array<bool, kBundle> occluded_;
    std::size_t count_ = 0;
    Rgb sum_;
};

}  // namespace

void add_direct_light(const Scene& scene, const RayScene& rays, const Receiver& receiver,
                      int light_samples, Acceptance accept, std::span<Rgb> E) {
    Bundle bundle(rays);
    const Vec3 origin = rays.offset_origin(receiver.position, receiver.n_g, receiver.n_g);
    for (std::size_t index = 0; index < scene.lights.size(); ++index) {
        const Light& light = scene.lights[index];
        if (light.off) continue;
        const int count = is_delta(light) ? 1 : light_samples;
        const Sobol2d sequence(receiver.seed + index);
        for (int k = 0; k < count; ++k) {
            const auto sample = sample_light(light, receiver.position, receiver.n,
                                             sequence(receiver.first_ray + std::uint32_t(k)));
            if (!sample) continue;
            const float cos_i = glm::dot(sample->w_i, receiver.n);
            if (cos_i <= 0 || glm::dot(sample->w_i, receiver.n_g) <= 0) continue;
            bundle.add({origin, sample->w_i, sample->distance},
                       cos_i * accept(cos_i) * sample->radiance);
        }
        E[light.group] += bundle.finish() / float(count);
    }
}

Rgb scaled_sum(std::span<const LightGroup> groups, std::span<const Rgb> of_group) {
    Rgb sum;
    for (std::size_t g = 0; g < groups.size(); ++g) sum += groups[g].scale * of_group[g];
    return sum;
}

}  // namespace tallow
