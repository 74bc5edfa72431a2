// SPDX-License-Identifier: Apache-2.0
// How each light is sampled and seen. Area lights: the quad by area, the sphere by the cone of
// directions in which it appears, the environment by cosine.
#include "common/scene/light.h"

#include <algorithm>
#include <cmath>

#include "common/base/overloaded.h"

namespace tallow {
namespace {

using Sample = std::optional<LightSample>;

// Direction and distance from x to p; nothing if they coincide.
std::optional<std::pair<Vec3, float>> towards(Vec3 x, Vec3 p) {
    const DVec3 d = DVec3(p) - DVec3(x);
    const double distance = glm::length(d);
    if (!(distance > 0)) return std::nullopt;
    return std::pair(Vec3(d / distance), float(distance));
}

// Cubic step from 0 at cos_outer to 1 at cos_inner.
float cone_falloff(const SpotLight& spot, float cosine) {
    if (cosine <= spot.cos_outer) return 0;
    if (cosine >= spot.cos_inner) return 1;
    const float t = (cosine - spot.cos_outer) / (spot.cos_inner - spot.cos_outer);
    return t * t * (3 - 2 * t);
}

Sample sample_point(Vec3 position, Rgb intensity, Vec3 x) {
    const auto to = towards(x, position);
    if (!to) return std::nullopt;
    return LightSample{to->first, to->second, intensity / to->second / to->second};
}

Sample sample_spot(const SpotLight& spot, Vec3 x) {
    Sample sample = sample_point(spot.position, spot.intensity, x);
    if (!sample) return sample;
    const float falloff = cone_falloff(spot, -glm::dot(sample->w_i, spot.direction));
    if (falloff == 0) return std::nullopt;
    sample->radiance *= falloff;
    return sample;
}

Sample sample_quad(const QuadLight& quad, Vec3 x, Vec2 u) {
    const auto to = towards(x, quad.center + (u.x - 0.5f) * quad.u + (u.y - 0.5f) * quad.v);
    if (!to) return std::nullopt;
    const float cos_light = -glm::dot(to->first, quad.normal);
    if (cos_light <= 0) return std::nullopt;
    // pdf over solid angle = distance^2 / (cos_light area)
    const float area = glm::length(glm::cross(quad.u, quad.v));
    const float weight = cos_light * area / (to->second * to->second);
    return LightSample{to->first, to->second, weight * quad.radiance};
}

// Distance from the ray's origin to the sphere's near side, or nothing.
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

Sample sample_sphere(const SphereLight& sphere, Vec3 x, Vec2 u) {
    const auto to_center = towards(x, sphere.center);
    if (!to_center || to_center->second <= sphere.radius) return std::nullopt;
    const float sin_max = sphere.radius / to_center->second;
    // 1 - cos of the half angle, without cancellation for small and far spheres
    const float one_minus_cos_max = sin_max * sin_max / (1 + std::sqrt(1 - sin_max * sin_max));
    const float one_minus_cos = u.x * one_minus_cos_max;
    const float sine = std::sqrt(std::max(0.0f, one_minus_cos * (2 - one_minus_cos)));
    const float phi = kTwoPi * u.y;
    const Vec3 w_i = glm::normalize(
        make_frame(to_center->first)
            .to_world({sine * std::cos(phi), sine * std::sin(phi), 1 - one_minus_cos}));
    // A direction at the rim may miss by rounding: there the rim is at the tangent's length.
    const float tangent = to_center->second * std::sqrt(1 - sin_max * sin_max);
    const float distance = cross_sphere(sphere, {x, w_i}).value_or(tangent);
    return LightSample{w_i, distance, kTwoPi * one_minus_cos_max * sphere.radiance};
}

// Uniform on the unit sphere.
Vec3 any_direction(Vec2 u) {
    const float phi = kTwoPi * u.y;
    const float z = 1 - 2 * u.x;
    const float sine = std::sqrt(std::max(0.0f, 1 - z * z));
    return {sine * std::cos(phi), sine * std::sin(phi), z};
}

Sample sample_environment(const EnvironmentLight& light, std::optional<Vec3> n, Vec2 u) {
    if (!n) return LightSample{any_direction(u), kInfinity, 4 * kPi * light.radiance};
    const float phi = kTwoPi * u.y;
    // pdf = cos / pi. 1 - u.x lies in (0, 1], so that the cosine is never zero.
    const float cosine = std::sqrt(1 - u.x);
    const float sine = std::sqrt(u.x);
    const Vec3 w_i = make_frame(*n).to_world({sine * std::cos(phi), sine * std::sin(phi), cosine});
    return LightSample{glm::normalize(w_i), kInfinity, kPi / cosine * light.radiance};
}

std::optional<Emission> see_quad(const QuadLight& quad, const Ray& ray) {
    const float cosine = -glm::dot(ray.direction, quad.normal);
    if (cosine <= 0) return std::nullopt;
    const float t = glm::dot(ray.origin - quad.center, quad.normal) / cosine;
    if (t <= 0) return std::nullopt;
    const Vec3 offset = ray.origin + t * ray.direction - quad.center;
    const float a = glm::dot(offset, quad.u) / length2(quad.u);
    const float b = glm::dot(offset, quad.v) / length2(quad.v);
    if (std::abs(a) > 0.5f || std::abs(b) > 0.5f) return std::nullopt;
    return Emission{t, quad.radiance};
}

}  // namespace

bool is_delta(const Light& light) {
    return std::holds_alternative<PointLight>(light.shape) ||
           std::holds_alternative<SpotLight>(light.shape) ||
           std::holds_alternative<DirectionalLight>(light.shape);
}

std::optional<LightSample> sample_light(const Light& light, Vec3 x, std::optional<Vec3> n, Vec2 u) {
    return std::visit(
        Overloaded{
            [&](const PointLight& l) { return sample_point(l.position, l.intensity, x); },
            [&](const DirectionalLight& l) {
                return Sample(LightSample{-l.direction, kInfinity, l.irradiance});
            },
            [&](const SpotLight& l) { return sample_spot(l, x); },
            [&](const QuadLight& l) { return sample_quad(l, x, u); },
            [&](const SphereLight& l) { return sample_sphere(l, x, u); },
            [&](const EnvironmentLight& l) { return sample_environment(l, n, u); },
        },
        light.shape);
}

LightPoint sample_light_point(const Light& light, Vec2 u) {
    return std::visit(Overloaded{
                          [](const PointLight& l) {
                              return LightPoint{l.position, Vec3(0), l.intensity};
                          },
                          [](const DirectionalLight& l) {
                              return LightPoint{-l.direction, l.direction, l.irradiance, true};
                          },
                          [](const SpotLight& l) {
                              return LightPoint{l.position, l.direction, l.intensity};
                          },
                          [&](const QuadLight& l) {
                              const float area = glm::length(glm::cross(l.u, l.v));
                              return LightPoint{l.center + (u.x - 0.5f) * l.u + (u.y - 0.5f) * l.v,
                                                l.normal, area * l.radiance};
                          },
                          [&](const SphereLight& l) {
                              const Vec3 n = any_direction(u);
                              return LightPoint{l.center + l.radius * n, n,
                                                4 * kPi * l.radius * l.radius * l.radiance};
                          },
                          [&](const EnvironmentLight& l) {
                              const Vec3 w = any_direction(u);
                              return LightPoint{w, -w, 4 * kPi * l.radiance, true};
                          },
                      },
                      light.shape);
}

Rgb intensity_towards(const Light& light, const LightPoint& point, Vec3 w) {
    const float cosine = glm::dot(w, point.axis);
    if (const auto* spot = std::get_if<SpotLight>(&light.shape))
        return cone_falloff(*spot, cosine) * point.strength;
    const bool has_area = std::holds_alternative<QuadLight>(light.shape) ||
                          std::holds_alternative<SphereLight>(light.shape);
    return has_area ? std::max(0.0f, cosine) * point.strength : point.strength;
}

std::optional<Emission> see_light(const Light& light, const Ray& ray) {
    if (const auto* quad = std::get_if<QuadLight>(&light.shape)) return see_quad(*quad, ray);
    if (const auto* environment = std::get_if<EnvironmentLight>(&light.shape))
        return Emission{kInfinity, environment->radiance};
    if (const auto* sphere = std::get_if<SphereLight>(&light.shape))
        if (const auto t = cross_sphere(*sphere, ray)) return Emission{*t, sphere->radiance};
    return std::nullopt;
}

}  // namespace tallow
