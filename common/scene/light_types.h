// SPDX-License-Identifier: Apache-2.0
#pragma once

// Behind light.h: what each type of light does. sample(), sample_point(), intensity() and see() are
// sample_light(), sample_light_point(), intensity_towards() and see_light() for one of them.

#include "common/scene/light.h"

namespace tallow {

using Sample = std::optional<LightSample>;
using Normal = std::optional<Vec3>;  // of the receiver

// Light from a point or a direction: light_delta.cpp. Never seen.
Sample sample(const PointLight& light, Vec3 x, const Normal& n, Vec2 u);
Sample sample(const DirectionalLight& light, Vec3 x, const Normal& n, Vec2 u);
Sample sample(const SpotLight& light, Vec3 x, const Normal& n, Vec2 u);
LightPoint sample_point(const PointLight& light, Vec2 u);
LightPoint sample_point(const DirectionalLight& light, Vec2 u);
LightPoint sample_point(const SpotLight& light, Vec2 u);
Rgb intensity(const PointLight& light, const LightPoint& point, Vec3 w, float distance);
Rgb intensity(const DirectionalLight& light, const LightPoint& point, Vec3 w, float distance);
Rgb intensity(const SpotLight& light, const LightPoint& point, Vec3 w, float distance);

// Lights with an area: light_quad.cpp, light_area.cpp.
Sample sample(const QuadLight& light, Vec3 x, const Normal& n, Vec2 u);
Sample sample(const DiscLight& light, Vec3 x, const Normal& n, Vec2 u);
Sample sample(const SphereLight& light, Vec3 x, const Normal& n, Vec2 u);
Sample sample(const MeshLight& light, Vec3 x, const Normal& n, Vec2 u);
LightPoint sample_point(const QuadLight& light, Vec2 u);
LightPoint sample_point(const DiscLight& light, Vec2 u);
LightPoint sample_point(const SphereLight& light, Vec2 u);
LightPoint sample_point(const MeshLight& light, Vec2 u);
Rgb intensity(const QuadLight& light, const LightPoint& point, Vec3 w, float distance);
Rgb intensity(const DiscLight& light, const LightPoint& point, Vec3 w, float distance);
Rgb intensity(const SphereLight& light, const LightPoint& point, Vec3 w, float distance);
Rgb intensity(const MeshLight& light, const LightPoint& point, Vec3 w, float distance);
float density(const QuadLight& light, Vec3 x, const Normal& n, Vec3 w);
float density(const DiscLight& light, Vec3 x, const Normal& n, Vec3 w);
float density(const SphereLight& light, Vec3 x, const Normal& n, Vec3 w);
float density(const MeshLight& light, Vec3 x, const Normal& n, Vec3 w);
std::optional<Emission> see(const QuadLight& light, const Ray& ray);
std::optional<Emission> see(const DiscLight& light, const Ray& ray);
std::optional<Emission> see(const SphereLight& light, const Ray& ray);
std::optional<Emission> see(const MeshLight& light, const Ray& ray);

// Light from all directions: light_environment.cpp.
Sample sample(const EnvironmentLight& light, Vec3 x, const Normal& n, Vec2 u);
LightPoint sample_point(const EnvironmentLight& light, Vec2 u);
Rgb intensity(const EnvironmentLight& light, const LightPoint& point, Vec3 w, float distance);
float density(const EnvironmentLight& light, Vec3 x, const Normal& n, Vec3 w);
std::optional<Emission> see(const EnvironmentLight& light, const Ray& ray);

/// Direction and distance from x to p; nothing if they coincide.
std::optional<std::pair<Vec3, float>> towards(Vec3 x, Vec3 p);

/// Light of `strength` = radiance / pdf over the area, from a point p with normal n_light.
Sample from_area(Vec3 x, Vec3 p, Vec3 n_light, Rgb strength);

/// Density over solid angle of a point drawn evenly from `area`, seen t away in unit direction w.
float area_density(float area, float t, Vec3 w, Vec3 n_light);

/// Intensity of a light's area element.
Rgb cosine_intensity(const LightPoint& point, Vec3 w);

/// Distance to where a ray meets the plane through `center` from the side of `normal`.
std::optional<float> cross_plane(Vec3 center, Vec3 normal, const Ray& ray);

/// Uniform on the unit sphere.
Vec3 any_direction(Vec2 u);

}  // namespace tallow
