// SPDX-License-Identifier: Apache-2.0
#include "common/lighting/direct_light.h"

#include "common/base/rng.h"
#include "common/optics/fresnel.h"

namespace tallow {

float Acceptance::operator()(float cos_i) const {
    return eta == 1 ? 1.0f : fresnel_transmittance(eta, cos_i);
}

void add_direct_light(const Scene& scene, const RayScene& rays, const Receiver& receiver,
                      int light_samples, Acceptance accept, std::span<Rgb> E) {
    for (std::size_t index = 0; index < scene.lights.size(); ++index) {
        const Light& light = scene.lights[index];
        const int count = is_delta(light) ? 1 : light_samples;
        Rgb sum;
        for (int k = 0; k < count; ++k) {
            const Vec2 u = sobol_2d(std::uint32_t(k), receiver.seed + index);
            const auto sample = sample_light(light, receiver.position, receiver.n, u);
            if (!sample) continue;
            const float cos_i = glm::dot(sample->w_i, receiver.n);
            if (cos_i <= 0 || glm::dot(sample->w_i, receiver.n_g) <= 0) continue;
            const Vec3 origin = rays.offset_origin(receiver.position, receiver.n_g, sample->w_i);
            if (rays.occluded(ShadowRay{origin, sample->w_i, sample->distance})) continue;
            sum += cos_i * accept(cos_i) * sample->radiance;
        }
        E[light.group] += sum / float(count);
    }
}

Rgb scaled_sum(std::span<const LightGroup> groups, std::span<const Rgb> of_group) {
    Rgb sum;
    for (std::size_t g = 0; g < groups.size(); ++g) sum += groups[g].scale * of_group[g];
    return sum;
}

}  // namespace tallow
