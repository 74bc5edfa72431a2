// SPDX-License-Identifier: Apache-2.0
// Backward paths with next-event estimation. One loop over vertices; what a surface adds and where
// the path goes on is decided per material.
#include "common/lighting/light_paths.h"

#include <algorithm>
#include <cmath>

#include "common/base/overloaded.h"
#include "common/base/rng.h"
#include "common/lighting/cosine_direction.h"
#include "common/lighting/direct_light.h"
#include "common/lighting/passage.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

// Numbers for the decisions of one vertex.
enum Stream : std::uint64_t { kRoulette = 1, kLobe, kDirection, kShadow };

// Chosen: what is left out is less than a ten-thousandth of what the same lamps would bring if the
// body were not there. Rays inside of bodies end after ln(1e4) = 9.2 mean free paths.
constexpr PassageLimits kPassages{1e-4f, 8};

// Turns the normals to the side of w_o: opaque surfaces have two sides.
void face(Hit& hit, Vec3 w_o) {
    if (glm::dot(hit.n_g, w_o) < 0) hit.n_g = -hit.n_g, hit.n = -hit.n;
    if (glm::dot(hit.n, w_o) <= 0) hit.n = hit.n_g;
}

Vec3 mirrored(const Hit& hit, Vec3 w_o) {
    const Vec3 direction = reflect(w_o, hit.n);
    return glm::normalize(glm::dot(direction, hit.n_g) > 0 ? direction : reflect(w_o, hit.n_g));
}

}  // namespace

/// A path on its way.
struct LightPaths::Walk {
    std::uint32_t receiver;
    std::uint64_t seed;
    Collect collect;
    std::span<Rgb> L;
    std::vector<BodyVertex>& bodies;
    Rgb throughput{1};
    int reflections = 0;              // by diffuse surfaces, so far
    std::vector<Onward> onward{};     // from the vertex that was met last
    std::vector<Passage> passages{};  // scratch
    std::vector<Rgb> E{};             // [group] scratch

    float random(Stream stream) const { return to_unit_float(random_bits(seed, stream, 0)); }
    Vec2 random_2d(Stream stream) const {
        return {random(stream), to_unit_float(random_bits(seed, stream, 1))};
    }
};

LightPaths::LightPaths(const Scene& scene, const RayScene& rays, int bounces,
                       std::vector<std::optional<Rgb>> diffuse)
    : scene_(scene), rays_(rays), bounces_(bounces), diffuse_(std::move(diffuse)) {
    diffuse_.resize(scene.objects.size());
    for (const Material& material : scene.materials) {
        const auto* body = std::get_if<SubsurfaceMaterial>(&material.kind);
        factors_.push_back(body ? std::optional(surface_factors(*body)) : std::nullopt);
        const auto* plastic = std::get_if<PlasticMaterial>(&material.kind);
        F_dr_.push_back(plastic ? float(diffuse_fresnel_reflectance(plastic->eta)) : 0.0f);
    }
}

void LightPaths::follow(Ray ray, std::uint32_t receiver, std::uint64_t seed, Collect collect,
                        std::span<Rgb> L, std::vector<BodyVertex>& bodies) const {
    Walk walk{receiver, seed, collect, L, bodies};
    walk.E.resize(scene_.groups.size());
    for (int mirrors = 0; mirrors <= kMostMirrors && walk.reflections <= bounces_;) {
        std::optional<Hit> hit = rays_.intersect(ray);
        if (!hit) return;
        walk.seed = mix_bits(walk.seed + 1);
        meet(*hit, -ray.direction, walk);
        std::erase_if(walk.onward, [&](const Onward& next) {
            return next.specular && meet_light(next.ray, next.weight, walk);
        });
        const std::optional<Onward> next = choose(walk);
        if (!next) return;
        ray = next->ray;
        walk.throughput *= next->weight;
        ++(next->specular ? mirrors : walk.reflections);
    }
}

// One of the ways on, by what they carry; none as often as they lose light together.
std::optional<LightPaths::Onward> LightPaths::choose(const Walk& walk) const {
    float total = 0;
    for (const Onward& next : walk.onward) total += max_channel(next.weight);
    const float all = std::max(1.0f, total);
    float left = walk.random(kRoulette) * all;
    for (const Onward& next : walk.onward) {
        const float share = max_channel(next.weight);
        if (left < share) return Onward{next.ray, next.weight * (all / share), next.specular};
        left -= share;
    }
    return std::nullopt;
}

// Lights in mirrors hide what is behind them, as they do from the camera.
bool LightPaths::meet_light(const Ray& ray, Rgb weight, const Walk& walk) const {
    std::optional<Emission> nearest;
    std::uint32_t group = 0;
    for (const Light& light : scene_.lights) {
        const std::optional<Emission> seen = see_light(light, ray);
        if (!seen || (nearest && nearest->t <= seen->t)) continue;
        nearest = seen, group = light.group;
    }
    if (!nearest || rays_.occluded({ray.origin, ray.direction, nearest->t})) return false;
    if (walk.collect == Collect::everything)
        walk.L[group] += walk.throughput * weight * nearest->radiance;
    return true;
}

// What the surface adds, and the ways on from it.
void LightPaths::meet(Hit hit, Vec3 w_o, Walk& walk) const {
    walk.onward.clear();
    const bool from_outside = glm::dot(hit.n_g, w_o) > 0;
    face(hit, w_o);
    const std::uint32_t index = scene_.objects[hit.object].material;
    const float cos_o = std::min(1.0f, glm::dot(hit.n, w_o));
    std::visit(Overloaded{
                   [&](const SubsurfaceMaterial& body) {
                       const float T = exit_factor(*factors_[index], cos_o);
                       const Rgb tint = surface_tint(scene_, body.albedo, hit);
                       if (const auto& total = diffuse_[hit.object])
                           return meet_coated(hit, w_o, T * tint * tint * *total, body.medium.eta,
                                              walk);
                       if (walk.reflections < bounces_)
                           walk.bodies.push_back({walk.receiver, hit.object, hit.position, hit.n,
                                                  w_o, kInvPi * T * tint * walk.throughput});
                       mirror(hit, w_o, Rgb(fresnel_reflectance(body.medium.eta, cos_o)), walk);
                       if (from_outside && body.transmission != Switch::off) pass(hit, w_o, walk);
                   },
                   [&](const DiffuseMaterial& diffuse) {
                       meet_base(hit, diffuse.reflectance.at(texture_point(scene_, hit)), 1, walk);
                   },
                   [&](const PlasticMaterial& plastic) {
                       const float F = fresnel_reflectance(plastic.eta, cos_o);
                       const Rgb reflectance = plastic.reflectance.at(texture_point(scene_, hit));
                       const Rgb base = (1 - F) / (plastic.eta * plastic.eta) * reflectance /
                                        (Rgb(1) - F_dr_[index] * reflectance);
                       meet_coated(hit, w_o, base, plastic.eta, walk);
                   },
                   [&](const MirrorMaterial& m) { mirror(hit, w_o, m.reflectance, walk); },
               },
               scene_.materials[index].kind);
}

void LightPaths::mirror(const Hit& hit, Vec3 w_o, Rgb weight, Walk& walk) const {
    const Vec3 w = mirrored(hit, w_o);
    walk.onward.push_back({{rays_.offset_origin(hit.position, hit.n_g, w), w}, weight, true});
}

void LightPaths::pass(const Hit& hit, Vec3 w_o, Walk& walk) const {
    walk.passages.clear();
    find_passages(scene_, rays_, hit, w_o, kPassages, walk.passages);
    for (const Passage& passage : walk.passages)
        walk.onward.push_back({passage.ray, passage.weight, true});
}

// A Lambertian layer under a smooth coat: one of the two goes on, chosen by what it carries.
void LightPaths::meet_coated(const Hit& hit, Vec3 w_o, Rgb base, float eta, Walk& walk) const {
    const float F = fresnel_reflectance(eta, std::min(1.0f, glm::dot(hit.n, w_o)));
    meet_base(hit, base, eta, walk);
    const float by_coat = F / std::max(1e-6f, F + max_channel(base));
    if (walk.random(kLobe) < by_coat) {
        walk.onward.clear();
        mirror(hit, w_o, Rgb(F / by_coat), walk);
    } else if (!walk.onward.empty()) {
        walk.onward.back().weight *= 1 / (1 - by_coat);
    }
}

// A Lambertian layer that reflects the share `rho` of the light that passes a boundary of index
// `eta` above it.
void LightPaths::meet_base(const Hit& hit, Rgb rho, float eta, Walk& walk) const {
    if (walk.reflections >= bounces_ || max_channel(rho) == 0) return;
    if (walk.collect == Collect::everything) {
        std::fill(walk.E.begin(), walk.E.end(), Rgb(0));
        add_direct_light(scene_, rays_,
                         {hit.position, hit.n_g, hit.n, random_bits(walk.seed, kShadow, 0)}, 1,
                         {eta}, walk.E);
        for (std::size_t g = 0; g < walk.E.size(); ++g)
            walk.L[g] += kInvPi * walk.throughput * rho * walk.E[g];
    }
    const Vec3 w = cosine_direction(hit.n, walk.random_2d(kDirection));
    if (glm::dot(w, hit.n_g) <= 0) return;
    const float entering = Acceptance{eta}(std::max(0.0f, glm::dot(w, hit.n)));
    walk.onward.push_back(
        {{rays_.offset_origin(hit.position, hit.n_g, w), w}, entering * rho, false});
}

}  // namespace tallow
