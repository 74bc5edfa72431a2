// SPDX-License-Identifier: Apache-2.0
// Terms of the shading sum that need no look inside a body.
#include "render/shade.h"

#include <algorithm>
#include <cmath>

#include "common/base/overloaded.h"
#include "common/base/rng.h"
#include "common/lighting/cosine_direction.h"
#include "common/optics/fresnel.h"

namespace tallow {

ReflectedLight::ReflectedLight(const Scene& scene, const RayScene& rays, int bounces,
                               const std::vector<std::optional<Rgb>>& diffuse)
    : scene_(scene),
      rays_(rays),
      bounces_(bounces),
      paths_(scene, rays, bounces, diffuse),
      diffuse_(diffuse) {
    diffuse_.resize(scene.objects.size());
    for (const Material& material : scene.materials) {
        const auto* plastic = std::get_if<PlasticMaterial>(&material.kind);
        const auto* body = std::get_if<SubsurfaceMaterial>(&material.kind);
        factors_.push_back(body ? std::optional(surface_factors(*body)) : std::nullopt);
        F_dr_.push_back(plastic ? float(diffuse_fresnel_reflectance(plastic->eta)) : 0.0f);
    }
}

ReflectedLight::Base ReflectedLight::base_at(const ShadingPoint& point) const {
    const std::uint32_t index = scene_.objects[point.hit.object].material;
    const Material& material = scene_.materials[index];
    if (const auto* diffuse = std::get_if<DiffuseMaterial>(&material.kind))
        return {diffuse->reflectance.at(texture_point(scene_, point.hit)), {}};
    if (const auto* plastic = std::get_if<PlasticMaterial>(&material.kind)) {
        const float eta = plastic->eta;
        const float leaving =
            fresnel_transmittance(eta, glm::dot(point.hit.n, point.w_o)) / (eta * eta);
        const Rgb rho = plastic->reflectance.at(texture_point(scene_, point.hit));
        return {leaving * rho / (Rgb(1) - F_dr_[index] * rho), {eta}};
    }
    if (const auto& total = diffuse_[point.hit.object]) {
        const auto& body = std::get<SubsurfaceMaterial>(material.kind);
        const Rgb tint = surface_tint(scene_, body.albedo, point.hit);
        const float T = exit_factor(*factors_[index], glm::dot(point.hit.n, point.w_o));
        return {T * tint * tint * *total, {body.medium.eta}};
    }
    return {Rgb(0), {}};
}

Rgb ReflectedLight::direct(const ShadingPoint& point, int light_samples) const {
    const Base base = base_at(point);
    if (max_channel(base.factor) == 0) return {};
    return kInvPi * base.factor * direct_irradiance(point, light_samples, base.accept);
}

Rgb ReflectedLight::direct_irradiance(const ShadingPoint& point, int light_samples,
                                      Acceptance accept) const {
    std::vector<Rgb> E(scene_.groups.size());
    const Receiver receiver{point.hit.position, point.hit.n_g, point.hit.n, point.pixel_seed,
                            point.ray * std::uint32_t(light_samples)};
    add_direct_light(scene_, rays_, receiver, light_samples, accept, E);
    return scaled_sum(scene_.groups, E);
}

Rgb ReflectedLight::indirect(const ShadingPoint& point, int paths, std::uint32_t receiver,
                             std::vector<BodyVertex>& vertices) const {
    const Base base = base_at(point);
    if (bounces_ == 0 || max_channel(base.factor) == 0) return {};
    const Frame frame = make_frame(point.hit.n);
    // One sequence for all camera rays of the pixel.
    const Sobol2d directions(mix_bits(point.pixel_seed ^ 0x5851f42d4c957f2dull));
    std::vector<Rgb> L(scene_.groups.size());
    Rgb sum;
    for (int k = 0; k < paths; ++k) {
        const Vec2 u = directions(point.ray * std::uint32_t(paths) + std::uint32_t(k));
        const Vec3 w = cosine_direction(frame, u);
        if (glm::dot(w, point.hit.n_g) <= 0) continue;
        // The cosine and the density of directions leave a pi, which the surface's 1 / pi takes.
        const Rgb weight =
            base.accept(std::min(1.0f, glm::dot(w, point.hit.n))) / float(paths) * base.factor;
        const std::size_t first = vertices.size();
        std::fill(L.begin(), L.end(), Rgb(0));
        paths_.follow({rays_.offset_origin(point.hit.position, point.hit.n_g, w), w}, receiver,
                      mix_bits(point.seed + std::uint64_t(k) + 0x9e3779b97f4a7c15ull),
                      LightPaths::Collect::everything, L, vertices);
        for (std::size_t v = first; v < vertices.size(); ++v) vertices[v].factor *= weight;
        sum += weight * scaled_sum(scene_.groups, L);
    }
    return sum;
}

Rgb ReflectedLight::entering(const ShadingPoint& point, const SubsurfaceMaterial& material,
                             int light_samples) const {
    return surface_tint(scene_, material.albedo, point.hit) *
           direct_irradiance(point, light_samples, {material.medium.eta});
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
                return m.albedo.value * total;
            },
            [](const DiffuseMaterial& m) { return m.reflectance.value; },
            [](const PlasticMaterial& m) { return m.reflectance.value; },
            [](const MirrorMaterial& m) { return m.reflectance; },
        },
        material.kind);
}

}  // namespace tallow
