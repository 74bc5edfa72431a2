// SPDX-License-Identifier: Apache-2.0
// Terms of the shading sum that need no look inside a body.
#include "render/shade.h"

#include <algorithm>
#include <cmath>

#include "common/base/overloaded.h"
#include "common/lighting/direct_light.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

Rgb direct_light(const Scene& scene, const RayScene& rays, const ShadingPoint& point,
                 int light_samples, Acceptance accept) {
    const Receiver receiver{point.hit.position, point.hit.n_g, point.hit.n, point.pixel_seed,
                            point.ray * std::uint32_t(light_samples)};
    std::vector<Rgb> E(scene.groups.size());
    add_direct_light(scene, rays, receiver, light_samples, accept, E);
    return scaled_sum(scene.groups, E);
}

}  // namespace

Rgb reflect_direct_light(const Scene& scene, const RayScene& rays, const ShadingPoint& point,
                         int light_samples) {
    const Material& material = scene.materials[scene.objects[point.hit.object].material];
    const TexturePoint where = texture_point(scene, point.hit);
    if (const auto* diffuse = std::get_if<DiffuseMaterial>(&material.kind)) {
        return kInvPi * diffuse->reflectance.at(where) *
               direct_light(scene, rays, point, light_samples, {});
    }
    if (const auto* plastic = std::get_if<PlasticMaterial>(&material.kind)) {
        const float eta = plastic->eta;
        const Rgb E_t = direct_light(scene, rays, point, light_samples, {eta});
        const float F_dr = float(diffuse_fresnel_reflectance(eta));
        const float leaving =
            fresnel_transmittance(eta, glm::dot(point.hit.n, point.w_o)) / (eta * eta);
        const Rgb reflectance = plastic->reflectance.at(where);
        const Rgb base = reflectance / (Rgb(1) - F_dr * reflectance);
        return kInvPi * leaving * base * E_t;
    }
    return {};
}

int shadow_rays_of_pixel(double tolerance) {
    const double rays = std::log2(0.35 / std::max(tolerance, 1e-4));
    return 1 << int(std::lround(std::max(0.0, rays)));
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
            [](const DiffuseMaterial& m) { return m.reflectance.value; },
            [](const PlasticMaterial& m) { return m.reflectance.value; },
            [](const MirrorMaterial& m) { return m.reflectance; },
        },
        material.kind);
}

}  // namespace tallow
