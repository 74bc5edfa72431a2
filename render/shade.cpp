// SPDX-License-Identifier: Apache-2.0
// Terms of the shading sum that need no look inside a body.
#include "render/shade.h"

#include "common/base/overloaded.h"
#include "common/base/rng.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

// Irradiance on a surface, each direction weighted with transmittance(cos_i).
template <class Transmittance>
Rgb gather_light(const Scene& scene, const RayScene& rays, const ShadingPoint& point,
                 int light_samples, const Transmittance& transmittance) {
    const Hit& hit = point.hit;
    Rgb E;
    for (std::size_t index = 0; index < scene.lights.size(); ++index) {
        const Light& light = scene.lights[index];
        const int count = is_delta(light) ? 1 : light_samples;
        Rgb sum;
        for (int k = 0; k < count; ++k) {
            const Vec2 u = sobol_2d(std::uint32_t(k), point.seed + index);
            const auto sample = sample_light(light, hit.position, hit.n, u);
            if (!sample) continue;
            const float cos_i = glm::dot(sample->w_i, hit.n);
            if (cos_i <= 0 || glm::dot(sample->w_i, hit.n_g) <= 0) continue;
            const Vec3 origin = rays.offset_origin(hit.position, hit.n_g, sample->w_i);
            if (rays.occluded(ShadowRay{origin, sample->w_i, sample->distance})) continue;
            sum += cos_i * transmittance(cos_i) * sample->radiance;
        }
        E += scene.groups[light.group].scale * sum / float(count);
    }
    return E;
}

}  // namespace

SurfaceFactors surface_factors(const SubsurfaceMaterial& material) {
    const float eta = material.medium.eta;
    const bool normalized = material.exit == Exit::normalized;
    return {eta, normalized ? float(diffuse_fresnel_transmittance(eta)) : 1.0f};
}

float exit_factor(const SurfaceFactors& factors, float cos_o) {
    return fresnel_transmittance(factors.eta, cos_o) / factors.exit_norm;
}

Rgb reflect_direct_light(const Scene& scene, const RayScene& rays, const ShadingPoint& point,
                         int light_samples) {
    const Material& material = scene.materials[scene.objects[point.hit.object].material];
    if (const auto* diffuse = std::get_if<DiffuseMaterial>(&material.kind)) {
        const auto all = [](float) { return 1.0f; };
        return kInvPi * diffuse->reflectance * gather_light(scene, rays, point, light_samples, all);
    }
    if (const auto* plastic = std::get_if<PlasticMaterial>(&material.kind)) {
        const float eta = plastic->eta;
        const auto entering = [eta](float cos_i) { return fresnel_transmittance(eta, cos_i); };
        const Rgb E_t = gather_light(scene, rays, point, light_samples, entering);
        const float F_dr = float(diffuse_fresnel_reflectance(eta));
        const float leaving =
            fresnel_transmittance(eta, glm::dot(point.hit.n, point.w_o)) / (eta * eta);
        const Rgb base = plastic->reflectance / (Rgb(1) - F_dr * plastic->reflectance);
        return kInvPi * leaving * base * E_t;
    }
    return {};
}

Rgb albedo(const Material& material) {
    return std::visit(
        Overloaded{
            [](const SubsurfaceMaterial& m) {
                Rgb total;
                for (int c = 0; c < 3; ++c)
                    total[c] =
                        float(make_profile(m.model, m.medium, c, Orders::all)->total_reflectance());
                return total;
            },
            [](const DiffuseMaterial& m) { return m.reflectance; },
            [](const PlasticMaterial& m) { return m.reflectance; },
            [](const MirrorMaterial& m) { return m.reflectance; },
        },
        material.kind);
}

}  // namespace tallow
