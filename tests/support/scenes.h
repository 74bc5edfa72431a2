// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/scene/scene.h"

// Scenes and media made in code, for tests that need no file.
namespace tallow::test {

/// [JMLH01] figure 5.
inline Medium marble() { return {{0.0021f, 0.0041f, 0.0071f}, {2.19f, 2.62f, 3.0f}, 0, 1.5f}; }
inline Medium skim_milk() { return {{0.0014f, 0.0025f, 0.0142f}, {0.7f, 1.22f, 1.9f}, 0, 1.3f}; }

/// A scene of these lights, all in one group of scale 1.
inline Scene lit_scene(std::vector<LightShape> lights, int light_samples = 16) {
    Scene scene;
    scene.groups.push_back({"default", Rgb(1)});
    for (LightShape& light : lights) scene.lights.push_back({light, 0});
    scene.settings.light_samples = light_samples;
    return scene;
}

/// Horizontal square light of this side, facing down, its centre at `height` above the origin.
inline QuadLight ceiling(float height, float side, Rgb radiance) {
    return {{0, height, 0}, {side, 0, 0}, {0, 0, side}, {0, -1, 0}, radiance};
}

}  // namespace tallow::test
