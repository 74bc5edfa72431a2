// SPDX-License-Identifier: Apache-2.0
// Lights without a size: what reaches a point comes from one direction, so nothing is drawn.
#include <cmath>

#include "common/scene/light_types.h"

namespace tallow {
namespace {

Sample from_point(Vec3 position, Rgb intensity, Vec3 x) {
    const auto to = towards(x, position);
    if (!to) return std::nullopt;
    return LightSample{to->first, to->second, intensity / to->second / to->second};
}

// Cubic step from 0 at cos_outer to 1 at cos_inner.
float cone_falloff(const SpotLight& spot, float cosine) {
    if (cosine <= spot.cos_outer) return 0;
    if (cosine >= spot.cos_inner) return 1;
    const float t = (cosine - spot.cos_outer) / (spot.cos_inner - spot.cos_outer);
    return t * t * (3 - 2 * t);
}

}  // namespace

Sample sample(const PointLight& light, Vec3 x, const Normal&, Vec2) {
    return from_point(light.position, light.intensity, x);
}

Sample sample(const DirectionalLight& light, Vec3, const Normal&, Vec2) {
    return LightSample{-light.direction, kInfinity, light.irradiance};
}

Sample sample(const SpotLight& light, Vec3 x, const Normal&, Vec2) {
    Sample sample = from_point(light.position, light.intensity, x);
    if (!sample) return sample;
    const float falloff = cone_falloff(light, -glm::dot(sample->w_i, light.direction));
    if (falloff == 0) return std::nullopt;
    sample->radiance *= falloff;
    return sample;
}

LightPoint sample_point(const PointLight& light, Vec2) {
    return {light.position, Vec3(0), light.intensity};
}

LightPoint sample_point(const DirectionalLight& light, Vec2) {
    return {-light.direction, light.direction, light.irradiance, true};
}

LightPoint sample_point(const SpotLight& light, Vec2) {
    return {light.position, light.direction, light.intensity};
}

Rgb intensity(const PointLight&, const LightPoint& point, Vec3, float) { return point.strength; }

Rgb intensity(const DirectionalLight&, const LightPoint& point, Vec3, float) {
    return point.strength;
}

Rgb intensity(const SpotLight& light, const LightPoint& point, Vec3 w, float) {
    return cone_falloff(light, glm::dot(w, point.axis)) * point.strength;
}

}  // namespace tallow
