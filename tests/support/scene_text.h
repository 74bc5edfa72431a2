// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "common/scene/scene_yaml.h"

namespace tallow {

/// `text` as if it stood in folder/scene.yaml.
inline Scene scene_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
    return parse_scene(text, "folder/scene.yaml", overrides);
}

/// The shortest camera that is valid; one line, so that what follows starts on line 2.
inline const std::string kCamera =
    "cameras: {main: {type: perspective, position: [0, 0, 10], look_at: [0, 0, 0], fov_deg: 40, "
    "resolution: [4, 3]}}\n";

/// A scene with everything that the grammar has.
inline const std::string kFullScene = R"(unit: cm
cameras:
  main: {type: perspective, position: [0, 28, 110], look_at: [0, 19, 0], up: [0, 2, 0], fov_deg: 60, resolution: [640, 480]}
  top: {type: perspective, position: [0, 50, 0], look_at: [0, 0, 0], up: [0, 0, -1], fov_deg: 35, resolution: [1, 65536]}
materials:
  body: {type: subsurface, preset: marble, model: dipole, single_scattering: on, exit: classic, surface: smooth}
  candle: {type: subsurface, sigma_s_prime: [1.9, 1.6, 1.1], sigma_a: [0.002, 0.006, 0.03], eta: 1.43}
  forward: {type: subsurface, sigma_s: 10, sigma_a: 0.5, g: 0.75, eta: 1.3}
  floor: {type: diffuse, reflectance: [0.5, 0.25, 0]}
  cup: {type: plastic, reflectance: 0.25}
  glaze: {type: plastic, reflectance: 0.5, eta: 1.75}
  chrome: {type: mirror}
objects:
  - {shape: mesh, file: meshes/bunny.ply, material: body, normals: flat, transform: [{scale: 2}, {rotate_deg: [0, 1, 0, 90]}, {translate: [1, 0, 0]}]}
  - {shape: sphere, center: [0, 5, 0], radius: 0.5, material: candle}
  - {shape: cube, size: 3, material: forward}
  - {shape: cube, center: [15, 5, 0], size: [1, 2, 3], material: cup}
  - {shape: plane, point: [0, 0, 0], normal: [0, 2, 0], material: floor}
  - {shape: plane, point: [0, -1, 0], normal: [0, 1, 0], radius: 40, material: body}
  - {shape: disc, normal: [0, 0, -3], radius: 1, material: chrome}
  - {shape: mesh, file: /data/lamp.obj, material: glaze}
lights:
  - {type: quad, position: [0, 10, 0], look_at: [0, 10, -5], size: [4, 2], radiance: [20, 10, 5], group: key}
  - {type: point, position: [0, 50, 0], intensity: 100}
  - {type: directional, direction: [0, -3, 0], irradiance: [1, 2, 3], group: key}
  - {type: spot, position: [0, 9, 0], look_at: [0, 0, 0], intensity: 7, cone_deg: 60, inner_deg: 20, group: fill}
  - {type: spot, position: [0, 9, 0], direction: [2, 0, 0], intensity: 7, cone_deg: 90}
  - {type: sphere, position: [0, 8, 0], radius: 0.25, radiance: 3}
  - {type: environment, radiance: [1, 1, 2], group: fill}
groups:
  fill: {scale: [1, 2, 3]}
  key: {scale: 0.5}
settings: {tolerance: 0.02, samples: 4, light_samples: 32}
)";

}  // namespace tallow
