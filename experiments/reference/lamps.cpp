// SPDX-License-Identifier: Apache-2.0
#include "experiments/reference/lamps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "common/base/errors.h"
#include "common/base/rng.h"

namespace tallow::reference {
namespace {

// Draws by which a light's part of all power is estimated: it only steers how often a light is
// chosen.
constexpr std::uint32_t kTrials = 256;

/// Uniform over the directions from `origin` to a ball; all directions from inside it. The solid
/// angle of those, too.
struct Cone {
    Frame frame;
    float span;  // 1 - cosine of the half angle

    Cone(Vec3 origin, Vec3 center, float radius) : frame(make_frame({0, 0, 1})), span(2) {
        const Vec3 axis = center - origin;
        const float distance2 = length2(axis);
        if (distance2 <= radius * radius) return;
        frame = make_frame(axis / std::sqrt(distance2));
        const float sine2 = radius * radius / distance2;
        span = sine2 / (1 + std::sqrt(1 - sine2));
    }
    float solid_angle() const { return kTwoPi * span; }
    Vec3 draw(Vec2 u) const {
        const float below = u.x * span, z = 1 - below, phi = kTwoPi * u.y;
        const float sine = std::sqrt(below * (1 + z));
        return glm::normalize(frame.to_world({sine * std::cos(phi), sine * std::sin(phi), z}));
    }
};

}  // namespace

Lamps::Lamps(const Scene& scene, Vec3 center, float radius) : center_(center), radius_(radius) {
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        Light light = scene.lights[i];
        if (light.off || max_channel(scene.groups[light.group].scale) == 0) continue;
        if (is_delta(light))
            throw InputError(
                fmt::format("{}: lights[{}]: expected a light with an area or an environment, got "
                            "a point, spot or directional one, which no path over a mirror "
                            "reflection can end at",
                            scene.file.string(), i));
        const Rgb scale = scene.groups[light.group].scale;
        std::visit(
            [&](auto& shape) {
                if constexpr (requires { shape.radiance; }) shape.radiance *= scale;
            },
            light.shape);
        lights_.push_back(std::move(light));
    }
    for (int c = 0; c < 3; ++c) {
        std::vector<float>& up_to = up_to_[std::size_t(c)];
        float sum = 0;
        for (std::uint32_t lamp = 0; lamp < lights_.size(); ++lamp) {
            for (std::uint32_t i = 0; i < kTrials; ++i)
                if (const auto ray = send(lamp, c, sobol_2d(i, 1), sobol_2d(i, 2)))
                    sum += ray->power;
            up_to.push_back(sum);
        }
        // Nobody is left out, however little the trials found.
        const float least = sum > 0 ? 0.01f * sum / float(up_to.size()) : 1;
        for (std::size_t i = 0; i < up_to.size(); ++i) up_to[i] += float(i + 1) * least;
        for (float& part : up_to) part /= up_to.back();
    }
}

Lamps::Pick Lamps::pick(int channel, float u) const {
    const std::vector<float>& up_to = up_to_[std::size_t(channel)];
    const auto above = std::upper_bound(up_to.begin(), up_to.end() - 1, u);
    const auto lamp = std::uint32_t(above - up_to.begin());
    return {lamp, up_to[lamp] - (lamp > 0 ? up_to[lamp - 1] : 0)};
}

std::optional<Lamps::Ray> Lamps::send(std::uint32_t lamp, int channel, Vec2 at,
                                      Vec2 direction) const {
    const Light& light = lights_[lamp];
    const LightPoint point = sample_light_point(light, at);
    if (point.at_infinity) {
        const Frame frame = make_frame(point.position);
        const float r = radius_ * std::sqrt(direction.x);
        const float phi = kTwoPi * direction.y;
        const Vec3 aside = r * (std::cos(phi) * frame.s + std::sin(phi) * frame.t);
        const float power = point.strength[channel] * kPi * radius_ * radius_;
        if (!(power > 0)) return std::nullopt;
        return Ray{center_ + aside + 2 * radius_ * point.position, -point.position, power};
    }
    const Cone cone(point.position, center_, radius_);
    const Vec3 w = cone.draw(direction);
    const float power = intensity_towards(light, point, w, kInfinity)[channel] * cone.solid_angle();
    if (!(power > 0)) return std::nullopt;
    return Ray{point.position, w, power};
}

float Lamps::radiance(int channel, Vec3 origin, Vec3 direction, float length) const {
    float sum = 0;
    for (const Light& light : lights_) {
        const std::optional<Emission> seen = see_light(light, {origin, direction});
        if (seen && seen->t <= length) sum += seen->radiance[channel];
    }
    return sum;
}

}  // namespace tallow::reference
