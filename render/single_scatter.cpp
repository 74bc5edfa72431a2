// SPDX-License-Identifier: Apache-2.0
// Single scattering by marching refracted eye rays, many at a time. From each depth light is
// followed either along straight shadow rays through the surface with a corrected length inside, or
// along all paths that are refracted at the surface.
#include "render/single_scatter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/rng.h"
#include "common/optics/fresnel.h"
#include "common/optics/phase.h"
#include "render/depth_sampler.h"

namespace tallow {
namespace {

// Depths that are marched together. Chosen: what is kept of them fits into the first-level cache.
constexpr std::size_t kBatch = 256;

// Mean free paths of the clearest channel that light is followed through a body of finite extent
// along straight lines. Chosen: e^-40 is nothing, but the corrected length of a line that leaves
// under cos_i is shorter, and light at grazing angles is lost from depths of more than 40 cos_i
// paths: 5e-3 of what is scattered once at cos_i = 0.05, 0.07 at 0.025.
constexpr float kReach = 40;

float reach(const Surface& surface, Rgb sigma_t) {
    const bool half_space = std::holds_alternative<PlaneSurface>(surface);
    return half_space ? kInfinity : kReach / min_channel(sigma_t);
}

Rgb exp(Rgb x) {
    return map(x, [](float v) { return std::exp(v); });
}

/// A place inside where light is scattered towards the eye.
struct Place {
    std::size_t point;    // of the eye ray that it lies on
    std::uint32_t index;  // of its light samples in the point's sequences
    Vec3 x;               // mm
    Vec3 w_inside;        // unit, along the eye ray into the body
    Rgb weight;           // of what is scattered here in the radiance at the surface
};

/// Radiance that leaves the body, without sigma_s: sum over places of weight times the integral of
/// p L F_t cos_i / cos_i' e^(-sigma_t s_i').
class LightCollector {
public:
    LightCollector(const ScatteringBody& body, std::span<const EyePoint> points, std::span<Rgb> sum)
        : body_(body),
          points_(points),
          sum_(sum),
          sigma_t_(body.medium.sigma_t()),
          reach_(reach(body.surface, sigma_t_)) {}

    void add(std::span<const Place> places) {
        for (std::size_t light = 0; light < body_.scene.lights.size(); ++light) {
            scale_ = body_.scene.groups[body_.scene.lights[light].group].scale;
            if (max_channel(scale_) == 0) continue;
            if (body_.exact != nullptr)
                add_refracted_paths(places, light);
            else
                add_straight_lines(places, light);
        }
    }

private:
    Vec2 light_sample(const Place& place, std::size_t light) const {
        return sobol_2d(place.index, points_[place.point].seed + light);
    }

    void add_straight_lines(std::span<const Place> places, std::size_t light) {
        std::size_t count = 0;
        for (const Place& place : places) {
            const auto sample = sample_light(body_.scene.lights[light], place.x, std::nullopt,
                                             light_sample(place, light));
            if (!sample) continue;
            inside_[count] = {place.x, sample->w_i, std::min(sample->distance, reach_)};
            arriving_[count++] = {&place, sample->radiance, sample->distance};
        }
        body_.rays.intersect_object({inside_.data(), count}, body_.object, {exit_.data(), count});
        std::size_t leaving = 0;
        for (std::size_t k = 0; k < count; ++k)
            if (exit_[k] && enter(arriving_[k], inside_[k], *exit_[k], outside_[leaving]))
                arriving_[leaving++] = arriving_[k];
        body_.rays.occluded({outside_.data(), leaving}, {occluded_.data(), leaving});
        for (std::size_t k = 0; k < leaving; ++k)
            if (!occluded_[k]) add(*arriving_[k].place, arriving_[k].radiance);
    }

    /// Light on its way from a lamp to a place.
    struct Arriving {
        const Place* place;
        Rgb radiance;
        float distance;  // to the lamp
    };

    /// Follows light through the surface at `exit`, where the straight line towards it leaves the
    /// body; `outside` is the rest of that line. False if none enters.
    bool enter(Arriving& light, const ShadowRay& inside, const Hit& exit,
               ShadowRay& outside) const {
        if (!admits_light(exit.position)) return false;
        const float cos_g = glm::dot(inside.direction, exit.n_g);
        if (cos_g <= 0) return false;  // grazed from outside by rounding
        const float cos_n = glm::dot(inside.direction, exit.n);
        const Vec3 n = cos_n > 0 ? exit.n : exit.n_g;
        const float cos_i = cos_n > 0 ? cos_n : cos_g;
        const auto w_refracted = refract(inside.direction, n, body_.medium.eta);
        if (!w_refracted) return false;
        const float ratio = cos_i / refracted_cosine(body_.medium.eta, cos_i);
        const float phase =
            henyey_greenstein(body_.medium.g, -glm::dot(*w_refracted, light.place->w_inside));
        const float transmitted = fresnel_transmittance(body_.medium.eta, cos_i);
        light.radiance *= phase * transmitted * ratio * exp(-exit.t * ratio * sigma_t_) *
                          surface_tint(body_.scene, body_.albedo, exit);
        outside = {body_.rays.offset_origin(exit.position, exit.n_g, inside.direction),
                   inside.direction, light.distance - exit.t};
        return true;
    }

    void add_refracted_paths(std::span<const Place> places, std::size_t light_index) {
        const Light& light = body_.scene.lights[light_index];
        for (const Place& place : places) {
            const LightPoint y = sample_light_point(light, light_sample(place, light_index));
            for (const RefractedPath& path : body_.exact->find(place.x, y)) {
                const Rgb intensity = intensity_towards(light, y, -path.w_i, path.outside);
                if (max_channel(intensity) == 0 || !std::isfinite(path.spread) ||
                    blocked(place.x, path))
                    continue;
                const float phase =
                    henyey_greenstein(body_.medium.g, -glm::dot(path.w_inside, place.w_inside));
                const float cos_i = std::min(1.0f, glm::dot(path.w_i, path.n));
                const float transmitted = fresnel_transmittance(body_.medium.eta, cos_i);
                add(place, phase * transmitted * path.spread * intensity *
                               exp(-path.inside * sigma_t_) * tint_at(path.position, path.n_g));
            }
        }
    }

    // Whether the body ends before x_i on the way from x, or something stands before the light.
    bool blocked(Vec3 x, const RefractedPath& path) const {
        constexpr float kShort = 1 - 1e-4f;  // stops before x_i itself
        const RayScene& rays = body_.rays;
        if (rays.intersect_object({x, -path.w_inside}, body_.object, kShort * path.inside))
            return true;
        return rays.occluded(
            {rays.offset_origin(path.position, path.n_g, path.w_i), path.w_i, path.outside});
    }

    // Where only the place is known: the texture coordinates belong to a hit.
    Rgb tint_at(Vec3 position, Vec3 n_g) const {
        if (!body_.albedo.texture) return surface_tint(body_.scene, body_.albedo, {});
        const Vec3 above = body_.rays.offset_origin(position, n_g, n_g);
        const auto hit = body_.rays.intersect_object({above, -n_g}, body_.object,
                                                     2 * glm::length(above - position));
        // Off an edge by rounding there is none.
        return hit ? surface_tint(body_.scene, body_.albedo, *hit) : Rgb(0);
    }

    // A half-space takes light only through its opening.
    bool admits_light(Vec3 x) const {
        const auto* plane = std::get_if<PlaneSurface>(&body_.surface);
        return plane == nullptr || length2(x - plane->point) <= plane->radius * plane->radius;
    }

    void add(const Place& place, Rgb radiance) {
        sum_[place.point] += scale_ * place.weight * radiance;
    }

    const ScatteringBody& body_;
    std::span<const EyePoint> points_;
    std::span<Rgb> sum_;
    Rgb sigma_t_;
    float reach_;  // mm
    Rgb scale_;    // of the light's group
    std::array<Arriving, kBatch> arriving_;
    std::array<ShadowRay, kBatch> inside_, outside_;
    std::array<std::optional<Hit>, kBatch> exit_;
    std::array<bool, kBatch> occluded_;
};

/// Where step `index` of the `together` steps that are stratified together lies, in [0, 1). Steps
/// come in pairs, one stratum a pair, one the mirror image of the other in its middle: what changes
/// linearly over a stratum has no error.
float depth_sample(std::uint64_t seed, std::uint32_t index, int together) {
    const float u = sobol_third(index / 2, mix_bits(seed));
    if (index % 2 == 0) return u;
    const float strata = float(std::max(1, together / 2));
    const float below = std::floor(u * strata);
    return std::min((2 * below + 1) / strata - u, 0x1.fffffep-1f);
}

/// Lays places along the eye rays inside a body and collects the light there.
class March {
public:
    March(const ScatteringBody& body, std::span<const EyePoint> points, MarchSteps steps,
          std::span<Rgb> result)
        : points_(points),
          steps_(steps),
          sigma_t_(body.medium.sigma_t()),
          sigma_s_(body.medium.sigma_s()),
          collector_(body, points, result) {
        places_.reserve(kBatch);
    }

    /// `length` of the refracted ray inside, mm; infinite in a half-space.
    void along(std::size_t point, Vec3 w_inside, float length) {
        const EyePoint& eye = points_[point];
        const DepthSampler depths(sigma_t_, length);
        for (std::uint32_t k = 0; k < std::uint32_t(steps_.of_point); ++k) {
            const std::uint32_t index = eye.first_step + k;
            const Depth depth = depths(depth_sample(eye.seed, index, steps_.together));
            // Depths count from the surface itself: the offset only keeps the ray off it.
            places_.push_back({point, index, eye.hit.position + depth.s * w_inside, w_inside,
                               sigma_s_ * depth.weight});
            if (places_.size() == kBatch) finish();
        }
    }

    void finish() {
        collector_.add(places_);
        places_.clear();
    }

private:
    std::span<const EyePoint> points_;
    MarchSteps steps_;
    Rgb sigma_t_, sigma_s_;
    LightCollector collector_;
    std::vector<Place> places_;
};

}  // namespace

void single_scatter(const ScatteringBody& body, std::span<const EyePoint> points, MarchSteps steps,
                    std::span<Rgb> result) {
    std::fill(result.begin(), result.end(), Rgb(0));
    if (max_channel(body.medium.sigma_s_prime) == 0) return;
    const float eta = body.medium.eta;
    std::vector<ShadowRay> rays;        // [ray]
    std::vector<std::size_t> point_of;  // [ray]
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Hit& hit = points[i].hit;
        const auto w_inside = refract(points[i].w_o, hit.n, eta);
        if (!w_inside) continue;
        const Vec3 start = body.rays.offset_origin(hit.position, hit.n_g, *w_inside);
        rays.push_back({start, *w_inside, kInfinity});
        point_of.push_back(i);
    }
    std::vector<std::optional<Hit>> far_side(rays.size());
    body.rays.intersect_object(rays, body.object, far_side);
    March march(body, points, steps, result);
    for (std::size_t k = 0; k < rays.size(); ++k) {
        const Vec3 from = points[point_of[k]].hit.position;
        const float length = far_side[k] ? glm::length(far_side[k]->position - from) : kInfinity;
        if (length > 0) march.along(point_of[k], rays[k].direction, length);
    }
    march.finish();
    for (const std::size_t i : point_of) {
        const float transmitted =
            fresnel_transmittance(eta, glm::dot(points[i].w_o, points[i].hit.n));
        result[i] *= transmitted / (eta * eta * float(steps.of_point)) *
                     surface_tint(body.scene, body.albedo, points[i].hit);
    }
}

Rgb single_scatter(const ScatteringBody& body, const EyePoint& point, MarchSteps steps) {
    Rgb result;
    single_scatter(body, {&point, 1}, steps, {&result, 1});
    return result;
}

}  // namespace tallow
