// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "common/base/rgb.h"
#include "common/base/vec.h"
#include "common/scene/light_image.h"
#include "common/scene/mesh_emitter.h"

namespace tallow {

/// Radiant intensity in every direction. W/sr per channel, position in mm.
struct PointLight {
    Vec3 position;
    Rgb intensity;
};

/// Parallel light. `direction` is where it travels (unit); `irradiance` falls on a surface that
/// faces it, W/mm^2.
struct DirectionalLight {
    Vec3 direction;
    Rgb irradiance;
};

/// Point light with a cone: full intensity within cos_inner of the axis, none beyond cos_outer,
/// a smooth cubic step between.
struct SpotLight {
    Vec3 position;
    Vec3 direction;  // unit axis
    Rgb intensity;
    float cos_inner, cos_outer;
};

/// Rectangle center + a u + b v with a, b in [-1/2, 1/2]; shines to the side of `normal` only. A
/// texture multiplies its radiance: the picture fills the rectangle once, its top at b = 1/2, and
/// is upright and not mirrored for whoever it shines on.
struct QuadLight {
    Vec3 center;
    Vec3 u, v;  // full edges, mm, at a right angle
    Vec3 normal;
    Rgb radiance;
    std::shared_ptr<const LightImage> texture{};  // or null
};

/// Disc; shines to the side of `normal` only.
struct DiscLight {
    Vec3 center;
    Vec3 normal;
    float radius;
    Rgb radiance;
};

/// Sphere that shines outward.
struct SphereLight {
    Vec3 center;
    float radius;
    Rgb radiance;
};

/// Mesh that shines outward and hides its own light, as an opaque body does.
struct MeshLight {
    std::shared_ptr<const MeshEmitter> mesh;
    Rgb radiance;
};

/// Light from infinitely far away, of the same radiance from every direction, or of a picture of
/// all directions times `radiance`. Its middle is seen towards +z and its right quarter towards -x,
/// as OpenEXR defines latitude-longitude maps, before the picture is turned about +y by `rotation`.
struct EnvironmentLight {
    Rgb radiance;
    std::shared_ptr<const LightImage> image{};  // Layout::directions, or null
    float rotation = 0;                         // radians, from +z towards +x
};

using LightShape = std::variant<PointLight, DirectionalLight, SpotLight, QuadLight, DiscLight,
                                SphereLight, MeshLight, EnvironmentLight>;

/// A light and the group in which its intensity is changed. Lights cast light, not shadows on
/// others.
struct Light {
    LightShape shape;
    std::uint32_t group = 0;  // index into Scene::groups
    bool off = false;         // lights nothing: no shadow rays; seen all the same, in black
};

/// Light that may arrive at a point from one direction.
struct LightSample {
    Vec3 w_i;        ///< unit, towards the light
    float distance;  ///< to the light, mm; infinite for lights at infinity
    Rgb radiance;    ///< radiance / pdf, or irradiance on a facing surface for delta lights:
                     ///< multiply by cos_i and average over the samples to get irradiance
};

/// Whether all the light that reaches a point comes from one direction.
bool is_delta(const Light& light);

/// Draws the light that may reach `x`, obstacles not considered. `n` is the normal of a receiving
/// surface, or nothing for a point inside a volume (then an environment is drawn from all
/// directions). `u` in [0, 1)^2; ignored by delta lights. Nothing if none can reach it.
std::optional<LightSample> sample_light(const Light& light, Vec3 x, std::optional<Vec3> n, Vec2 u);

/// Density over solid angle with which sample_light(light, x, n, u) draws the direction w; 0 of
/// delta lights.
float light_density(const Light& light, Vec3 x, std::optional<Vec3> n, Vec3 w);

/// A ball that holds a light; nothing of one at infinity.
struct LightBall {
    Vec3 center;
    float radius;  // mm
};
std::optional<LightBall> bounding_ball(const Light& light);

/// Where light sets out, drawn without knowing a receiver: for light that is bent on its way.
struct LightPoint {
    Vec3 position;    ///< mm; of a light at infinity the unit direction towards it
    Vec3 axis{0.0f};  ///< normal of the light there
    Rgb strength;     ///< over the pdf: intensity along `axis` of an area element, of a point
                      ///< light in any direction; irradiance of parallel light
    bool at_infinity = false;
};

/// Lights with an area are drawn by it (textured ones also by brightness), the environment from all
/// directions. `u` in [0, 1)^2; ignored by delta lights. The average over samples of
/// intensity_towards() is that of the light.
LightPoint sample_light_point(const Light& light, Vec2 u);

/// Intensity in W/sr that leaves a light's sample in unit direction w towards somebody `distance`
/// mm away, or irradiance of parallel light.
Rgb intensity_towards(const Light& light, const LightPoint& point, Vec3 w, float distance);

/// What a ray sees of a light, obstacles not considered.
struct Emission {
    float t;  ///< distance, mm; infinite for an environment
    Rgb radiance;
};
/// Nothing if the ray misses it; delta lights are never seen.
std::optional<Emission> see_light(const Light& light, const Ray& ray);

}  // namespace tallow
