// SPDX-License-Identifier: Apache-2.0
// Places inside a body -> light that arrives there from every lamp, along straight shadow rays
// through the surface with a corrected length inside, or along all paths that are refracted at the
// surface.
#include "render/light_collector.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/rng.h"
#include "common/optics/fresnel.h"
#include "common/optics/phase.h"
#include "render/entry_directions.h"
#include "render/inner_light.h"

namespace tallow {
namespace {

// Mean free paths of the clearest channel that light is followed through a body of finite extent
// along straight lines. Chosen: e^-40 is nothing, but the corrected length of a line that leaves
// under cos_i is shorter, and light at grazing angles is lost from depths of more than 40 cos_i
// paths: 5e-3 of what is scattered once at cos_i = 0.05, 0.07 at 0.025.
constexpr float kReach = 40;

// Refracted paths are searched up to a length that is drawn: all of them to kSure mean free paths
// of the clearest channel, longer ones with a chance that falls as their light does. Chosen: a path
// that is drawn rarely brings no more than one of e^-kSure.
constexpr float kSure = 2;

float reach(const Surface& surface, Rgb sigma_t) {
    const bool half_space = std::holds_alternative<PlaneSurface>(surface);
    return half_space ? kInfinity : kReach / min_channel(sigma_t);
}

Rgb exp(Rgb x) {
    return map(x, [](float v) { return std::exp(v); });
}

}  // namespace

Rgb tint_at(const ScatteringBody& body, Vec3 position, Vec3 n_g) {
    if (!body.albedo.texture) return surface_tint(body.scene, body.albedo, {});
    const Vec3 above = body.rays.offset_origin(position, n_g, n_g);
    const auto hit =
        body.rays.intersect_object({above, -n_g}, body.object, 2 * glm::length(above - position));
    return hit ? surface_tint(body.scene, body.albedo, *hit) : Rgb(0);
}

LightCollector::LightCollector(const ScatteringBody& body, std::span<const EyePoint> points,
                               std::span<Rgb> sum)
    : body_(body),
      points_(points),
      sum_(sum),
      sigma_t_(body.medium.sigma_t()),
      reach_(reach(body.surface, sigma_t_)) {}

void LightCollector::add(std::span<const Place> places) {
    for (std::size_t light = 0; light < body_.scene.lights.size(); ++light) {
        scale_ = body_.scene.groups[body_.scene.lights[light].group].scale;
        if (max_channel(scale_) == 0) continue;
        if (body_.exact == nullptr)
            add_straight_lines(places, light);
        else if (!is_drawn(body_.scene.lights[light]))
            add_refracted_paths(places, light);
        else
            for (std::size_t first = 0; first < places.size(); first += kBatch)
                add_entering_rays(places.subspan(first, std::min(kBatch, places.size() - first)),
                                  light);
    }
    if (body_.inner != nullptr) add_inner_light(places);
}

bool LightCollector::is_drawn(const Light& light) const {
    if (!body_.exact->is_searched()) return false;
    const auto* sky = std::get_if<EnvironmentLight>(&light.shape);
    const bool even_sky = sky != nullptr && !sky->image;
    return body_.lamps == LampPaths::drawn ? !is_delta(light)
                                           : body_.lamps == LampPaths::sky_drawn && even_sky;
}

Vec2 LightCollector::light_sample(const Place& place, std::size_t light) const {
    return sobol_2d(place.index, points_[place.point].seed + light);
}

void LightCollector::add_straight_lines(std::span<const Place> places, std::size_t light) {
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

// Follows light through the surface at `exit`, where the straight line towards it leaves the body;
// `outside` is the rest of that line. False if none enters.
bool LightCollector::enter(Arriving& light, const ShadowRay& inside, const Hit& exit,
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

void LightCollector::add_entering_rays(std::span<const Place> places, std::size_t light_index) {
    const Light& lamp = body_.scene.lights[light_index];
    const auto ball = bounding_ball(lamp);
    if (ball) follow_straight_lines(places, light_index, *ball);
    std::size_t count = 0;
    for (std::size_t k = 0; k < places.size(); ++k) {
        EntryDirections directions(lamp, ball, places[k].x, body_.medium.eta);
        add_normals(places[k], ball, ball ? exit_[k] : std::nullopt, directions);
        if (directions.empty()) continue;
        const auto w = directions.draw(light_sample(places[k], light_index));
        if (!w) continue;
        inside_[count] = {places[k].x, *w, kInfinity};
        arriving_[count++] = {&places[k], Rgb(1 / directions.density(*w)), 0};
    }
    body_.rays.intersect_object({inside_.data(), count}, body_.object, {exit_.data(), count});
    std::size_t leaving = 0;
    for (std::size_t k = 0; k < count; ++k)
        if (exit_[k] && bend_outwards(arriving_[k], inside_[k], *exit_[k], lamp, outside_[leaving]))
            arriving_[leaving++] = arriving_[k];
    body_.rays.occluded({outside_.data(), leaving}, {occluded_.data(), leaving});
    for (std::size_t k = 0; k < leaving; ++k)
        if (!occluded_[k]) add(*arriving_[k].place, arriving_[k].radiance);
}

// Where straight lines from places to a lamp leave the body: normals there bend its light.
void LightCollector::follow_straight_lines(std::span<const Place> places, std::size_t light_index,
                                           const LightBall& ball) {
    const Light& lamp = body_.scene.lights[light_index];
    for (std::size_t k = 0; k < places.size(); ++k) {
        const Place& place = places[k];
        const Vec2 u = sobol_2d(place.index, points_[place.point].seed + 0x9170 + light_index);
        const auto sample = sample_light(lamp, place.x, std::nullopt, u);
        const Vec3 w = sample ? sample->w_i : glm::normalize(ball.center - place.x);
        inside_[k] = {place.x, w, reach_};
    }
    body_.rays.intersect_object({inside_.data(), places.size()}, body_.object,
                                {exit_.data(), places.size()});
}

// The normal where the eye looks into the body and that where a straight line leaves it, each with
// what it would bring if the surface were a plane there.
void LightCollector::add_normals(const Place& place, const std::optional<LightBall>& ball,
                                 const std::optional<Hit>& exit,
                                 EntryDirections& directions) const {
    const Hit& seen = points_[place.point].hit;
    const Vec3 to_lamp = ball ? glm::normalize(ball->center - place.x) : seen.n;
    const auto likely = [&](Vec3 n, float depth) {
        constexpr float kLeastCos = 0.02f;
        const float cosine = std::max(kLeastCos, glm::dot(to_lamp, n));
        const float inside = refracted_cosine(body_.medium.eta, cosine);
        return fresnel_transmittance(body_.medium.eta, cosine) * cosine / inside *
               mean(place.weight * exp(-std::max(0.0f, depth) / inside * sigma_t_));
    };
    constexpr float kBeyondHorizon = -0.2f;  // parts of the surface near it may see the lamp
    float here = 0, there = 0;
    if (glm::dot(to_lamp, seen.n) > kBeyondHorizon)
        here = likely(seen.n, glm::dot(seen.position - place.x, seen.n_g));
    if (exit) there = likely(exit->n, glm::dot(exit->position - place.x, exit->n_g));
    constexpr float kLeastChance = 0.1f;
    const float least = kLeastChance * (here + there);
    if (here > 0) directions.add(seen.n, std::max(here, least));
    if (there > 0) directions.add(exit->n, std::max(there, least));
}

// Follows a ray from a place to what it sees outside: `outside` is what shadows may fall on. False
// if it does not see the lamp.
bool LightCollector::bend_outwards(Arriving& light, const ShadowRay& inside, const Hit& exit,
                                   const Light& lamp, ShadowRay& outside) const {
    const float eta = body_.medium.eta;
    const float cos_d = glm::dot(inside.direction, exit.n);
    const float cos_dg = glm::dot(inside.direction, exit.n_g);
    if (cos_d <= 0 || cos_dg <= 0 || !admits_light(exit.position)) return false;
    const auto w = refract_outwards(inside.direction, exit.n, eta);
    if (!w) return false;
    const float cos_w = glm::dot(*w, exit.n), cos_wg = glm::dot(*w, exit.n_g);
    if (cos_w <= 0 || cos_wg <= 0) return false;
    outside = {body_.rays.offset_origin(exit.position, exit.n_g, *w), *w, kInfinity};
    const auto seen = see_light(lamp, {outside.origin, *w});
    if (!seen || max_channel(seen->radiance) == 0) return false;
    outside.length = seen->t;
    // Interpolated normals bend a beam by other angles than those under which it meets the surface.
    const float beam = cos_wg * cos_d / (cos_dg * cos_w);
    const float phase =
        henyey_greenstein(body_.medium.g, glm::dot(inside.direction, light.place->w_inside));
    light.radiance *= phase * eta * eta * fresnel_transmittance(eta, cos_w) * beam *
                      seen->radiance * exp(-exit.t * sigma_t_) *
                      surface_tint(body_.scene, body_.albedo, exit);
    return true;
}

void LightCollector::add_refracted_paths(std::span<const Place> places, std::size_t light_index) {
    queries_.clear();
    for (const Place& place : places)
        queries_.push_back(
            {place.x,
             sample_light_point(body_.scene.lights[light_index], light_sample(place, light_index)),
             draw_reach(place, light_index)});
    body_.exact->find(queries_, [&](std::size_t i, const RefractedPath& path) {
        add_path(places[i], light_index, queries_[i].y, path);
    });
    add_unblocked();
}

float LightCollector::draw_reach(const Place& place, std::size_t light_index) const {
    if (!body_.exact->is_searched()) return kInfinity;
    const float u =
        to_unit_float(random_bits(points_[place.point].seed, 0x5ea4c8 + light_index, place.index));
    return (kSure - std::log1p(-u)) / min_channel(sigma_t_);
}

void LightCollector::add_path(const Place& place, std::size_t light_index, const LightPoint& y,
                              const RefractedPath& path) {
    const Rgb intensity =
        intensity_towards(body_.scene.lights[light_index], y, -path.w_i, path.outside);
    if (max_channel(intensity) == 0 || !std::isfinite(path.spread)) return;
    const float phase = henyey_greenstein(body_.medium.g, -glm::dot(path.w_inside, place.w_inside));
    const float cos_i = std::min(1.0f, glm::dot(path.w_i, path.n));
    const float transmitted = fresnel_transmittance(body_.medium.eta, cos_i);
    // e^(-sigma_t s) over the chance that so long a path was searched.
    const float unlikely = body_.exact->is_searched()
                               ? std::max(0.0f, path.inside * min_channel(sigma_t_) - kSure)
                               : 0.0f;
    const Rgb arrives = exp(Rgb(unlikely) - path.inside * sigma_t_);
    constexpr float kShort = 1 - 1e-4f;  // stops before x_i itself
    inside_[paths_] = {place.x, -path.w_inside, kShort * path.inside};
    outside_[paths_] = {body_.rays.offset_origin(path.position, path.n_g, path.w_i), path.w_i,
                        path.outside};
    arriving_[paths_++] = {&place,
                           phase * transmitted * path.spread * intensity * arrives *
                               tint_at(body_, path.position, path.n_g),
                           path.outside};
    if (paths_ == kBatch) add_unblocked();
}

// Adds the light of paths on which the body does not end before x_i, and nothing stands before the
// light.
void LightCollector::add_unblocked() {
    const std::size_t count = std::exchange(paths_, 0);
    body_.rays.intersect_object({inside_.data(), count}, body_.object, {exit_.data(), count});
    std::size_t entering = 0;
    for (std::size_t k = 0; k < count; ++k) {
        if (exit_[k]) continue;
        arriving_[entering] = arriving_[k], outside_[entering] = outside_[k];
        ++entering;
    }
    body_.rays.occluded({outside_.data(), entering}, {occluded_.data(), entering});
    for (std::size_t k = 0; k < entering; ++k)
        if (!occluded_[k]) add(*arriving_[k].place, arriving_[k].radiance);
}

// Its direction is not known: it is scattered as if g were 0.
void LightCollector::add_inner_light(std::span<const Place> places) {
    for (const Place& place : places)
        sum_[place.point] += 0.25f * kInvPi * place.weight * body_.inner->fluence(place.x);
}

// A half-space takes light only through its opening.
bool LightCollector::admits_light(Vec3 x) const {
    const auto* plane = std::get_if<PlaneSurface>(&body_.surface);
    return plane == nullptr || length2(x - plane->point) <= plane->radius * plane->radius;
}

}  // namespace tallow
