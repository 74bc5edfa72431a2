// SPDX-License-Identifier: Apache-2.0
// Hands each question about a light to its type.
#include "common/scene/light.h"

#include <cmath>

#include "common/base/overloaded.h"
#include "common/scene/light_types.h"

namespace tallow {

std::optional<std::pair<Vec3, float>> towards(Vec3 x, Vec3 p) {
    const DVec3 d = DVec3(p) - DVec3(x);
    const double distance = glm::length(d);
    if (!(distance > 0)) return std::nullopt;
    return std::pair(Vec3(d / distance), float(distance));
}

Vec3 any_direction(Vec2 u) {
    const float phi = kTwoPi * u.y;
    const float z = 1 - 2 * u.x;
    const float sine = std::sqrt(std::max(0.0f, 1 - z * z));
    return {sine * std::cos(phi), sine * std::sin(phi), z};
}

bool is_delta(const Light& light) {
    return std::visit(
        Overloaded{[](const PointLight&) { return true; },
                   [](const DirectionalLight&) { return true; },
                   [](const SpotLight&) { return true; }, [](const auto&) { return false; }},
        light.shape);
}

Sample sample_light(const Light& light, Vec3 x, std::optional<Vec3> n, Vec2 u) {
    return std::visit([&](const auto& l) { return sample(l, x, n, u); }, light.shape);
}

float light_density(const Light& light, Vec3 x, std::optional<Vec3> n, Vec3 w) {
    return std::visit(Overloaded{[](const PointLight&) { return 0.0f; },
                                 [](const DirectionalLight&) { return 0.0f; },
                                 [](const SpotLight&) { return 0.0f; },
                                 [&](const auto& l) { return density(l, x, n, w); }},
                      light.shape);
}

std::optional<LightBall> bounding_ball(const Light& light) {
    using Ball = std::optional<LightBall>;
    return std::visit(
        Overloaded{
            [](const PointLight& l) {
                return Ball({l.position, 0});
            },
            [](const SpotLight& l) {
                return Ball({l.position, 0});
            },
            [](const DirectionalLight&) { return Ball(); },
            [](const EnvironmentLight&) { return Ball(); },
            [](const QuadLight& l) {
                return Ball({l.center, 0.5f * glm::length(l.u + l.v)});
            },
            [](const MeshLight& l) {
                const Box box = l.mesh->box();
                return Ball({0.5f * (box.low + box.high), 0.5f * glm::length(box.high - box.low)});
            },
            [](const auto& l) {
                return Ball({l.center, l.radius});
            }},
        light.shape);
}

LightPoint sample_light_point(const Light& light, Vec2 u) {
    return std::visit([&](const auto& l) { return sample_point(l, u); }, light.shape);
}

Rgb intensity_towards(const Light& light, const LightPoint& point, Vec3 w, float distance) {
    return std::visit([&](const auto& l) { return intensity(l, point, w, distance); }, light.shape);
}

std::optional<Emission> see_light(const Light& light, const Ray& ray) {
    using Seen = std::optional<Emission>;
    return std::visit(Overloaded{[](const PointLight&) { return Seen(); },
                                 [](const DirectionalLight&) { return Seen(); },
                                 [](const SpotLight&) { return Seen(); },
                                 [&](const auto& l) { return see(l, ray); }},
                      light.shape);
}

}  // namespace tallow
