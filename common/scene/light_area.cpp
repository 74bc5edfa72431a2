// SPDX-License-Identifier: Apache-2.0
// Disc, sphere and mesh, and what all lights with an area share. Disc and mesh are drawn by area,
// the sphere by the cone of directions in which it appears.
#include <algorithm>
#include <cmath>

#include "common/scene/light_types.h"

namespace tallow {
namespace {

/// Distance from the ray's origin to the sphere's near side, or nothing.
std::optional<float> cross_sphere(const SphereLight& sphere, const Ray& ray) {
    const DVec3 o = DVec3(ray.origin) - DVec3(sphere.center);
    const double b = glm::dot(o, DVec3(ray.direction));
    const DVec3 nearest = o - b * DVec3(ray.direction);
    const double h2 = double(sphere.radius) * sphere.radius - glm::dot(nearest, nearest);
    if (h2 < 0) return std::nullopt;
    const double t = -b - std::sqrt(h2);
    if (t <= 0) return std::nullopt;
    return float(t);
}

// 1 - cos of the half angle of a sphere, without cancellation for small and far ones.
float one_minus_cos_of_rim(float sine) { return sine * sine / (1 + std::sqrt(1 - sine * sine)); }

}  // namespace

Sample from_area(Vec3 x, Vec3 p, Vec3 n_light, Rgb strength) {
    const auto to = towards(x, p);
    if (!to) return std::nullopt;
    const float cos_light = -glm::dot(to->first, n_light);
    if (cos_light <= 0) return std::nullopt;
    // pdf over solid angle = pdf over area * distance^2 / cos_light
    return LightSample{to->first, to->second, cos_light / (to->second * to->second) * strength};
}

float area_density(float area, float t, Vec3 w, Vec3 n_light) {
    return t * t / (area * std::max(1e-6f, -glm::dot(w, n_light)));
}

Rgb cosine_intensity(const LightPoint& point, Vec3 w) {
    return std::max(0.0f, glm::dot(w, point.axis)) * point.strength;
}

std::optional<float> cross_plane(Vec3 center, Vec3 normal, const Ray& ray) {
    const float cosine = -glm::dot(ray.direction, normal);
    if (cosine <= 0) return std::nullopt;
    const float t = glm::dot(ray.origin - center, normal) / cosine;
    return t > 0 ? std::optional(t) : std::nullopt;
}

LightPoint sample_point(const DiscLight& light, Vec2 u) {
    const Frame frame = make_frame(light.normal);
    const float r = light.radius * std::sqrt(u.x), phi = kTwoPi * u.y;
    return {light.center + r * (std::cos(phi) * frame.s + std::sin(phi) * frame.t), light.normal,
            kPi * light.radius * light.radius * light.radiance};
}

Sample sample(const DiscLight& light, Vec3 x, const Normal&, Vec2 u) {
    const LightPoint p = sample_point(light, u);
    return from_area(x, p.position, p.axis, p.strength);
}

float density(const DiscLight& light, Vec3 x, const Normal&, Vec3 w) {
    const auto seen = see(light, {x, w});
    return seen ? area_density(kPi * light.radius * light.radius, seen->t, w, light.normal) : 0;
}

Rgb intensity(const DiscLight&, const LightPoint& point, Vec3 w, float) {
    return cosine_intensity(point, w);
}

std::optional<Emission> see(const DiscLight& light, const Ray& ray) {
    const auto t = cross_plane(light.center, light.normal, ray);
    if (!t) return std::nullopt;
    const Vec3 offset = ray.origin + *t * ray.direction - light.center;
    if (length2(offset) > light.radius * light.radius) return std::nullopt;
    return Emission{*t, light.radiance};
}

Sample sample(const SphereLight& light, Vec3 x, const Normal&, Vec2 u) {
    const auto to_center = towards(x, light.center);
    if (!to_center || to_center->second <= light.radius) return std::nullopt;
    const float sin_max = light.radius / to_center->second;
    const float one_minus_cos_max = one_minus_cos_of_rim(sin_max);
    const float one_minus_cos = u.x * one_minus_cos_max;
    const float sine = std::sqrt(std::max(0.0f, one_minus_cos * (2 - one_minus_cos)));
    const float phi = kTwoPi * u.y;
    const Vec3 w_i = glm::normalize(
        make_frame(to_center->first)
            .to_world({sine * std::cos(phi), sine * std::sin(phi), 1 - one_minus_cos}));
    // A direction at the rim may miss by rounding: there the rim is at the tangent's length.
    const float tangent = to_center->second * std::sqrt(1 - sin_max * sin_max);
    const float distance = cross_sphere(light, {x, w_i}).value_or(tangent);
    return LightSample{w_i, distance, kTwoPi * one_minus_cos_max * light.radiance};
}

LightPoint sample_point(const SphereLight& light, Vec2 u) {
    const Vec3 n = any_direction(u);
    return {light.center + light.radius * n, n,
            4 * kPi * light.radius * light.radius * light.radiance};
}

float density(const SphereLight& light, Vec3 x, const Normal&, Vec3 w) {
    const auto to_center = towards(x, light.center);
    if (!to_center || to_center->second <= light.radius || !cross_sphere(light, {x, w})) return 0;
    return 1 / (kTwoPi * one_minus_cos_of_rim(light.radius / to_center->second));
}

Rgb intensity(const SphereLight&, const LightPoint& point, Vec3 w, float) {
    return cosine_intensity(point, w);
}

std::optional<Emission> see(const SphereLight& light, const Ray& ray) {
    const auto t = cross_sphere(light, ray);
    return t ? std::optional(Emission{*t, light.radiance}) : std::nullopt;
}

LightPoint sample_point(const MeshLight& light, Vec2 u) {
    const MeshEmitter::Point p = light.mesh->draw(u);
    return {p.position, p.normal, light.mesh->area() * light.radiance};
}

Sample sample(const MeshLight& light, Vec3 x, const Normal&, Vec2 u) {
    const LightPoint p = sample_point(light, u);
    const Sample sample = from_area(x, p.position, p.axis, p.strength);
    if (!sample || light.mesh->hides({p.position, p.axis}, -sample->w_i, sample->distance))
        return std::nullopt;
    return sample;
}

float density(const MeshLight& light, Vec3 x, const Normal&, Vec3 w) {
    const auto crossing = light.mesh->cross({x, w});
    return crossing ? area_density(light.mesh->area(), crossing->t, w, crossing->normal) : 0;
}

Rgb intensity(const MeshLight& light, const LightPoint& point, Vec3 w, float distance) {
    const Rgb I = cosine_intensity(point, w);
    if (max_channel(I) == 0 || light.mesh->hides({point.position, point.axis}, w, distance))
        return {};
    return I;
}

std::optional<Emission> see(const MeshLight& light, const Ray& ray) {
    const auto crossing = light.mesh->cross(ray);
    return crossing ? std::optional(Emission{crossing->t, light.radiance}) : std::nullopt;
}

}  // namespace tallow
