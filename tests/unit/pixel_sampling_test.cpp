// SPDX-License-Identifier: Apache-2.0
// One large pixel of many camera rays against many small pixels of one: places in the pixel must
// not be tied to places on lamps, nor to directions of indirect light.
#include <gtest/gtest.h>

#include <numeric>

#include "render/render_image.h"
#include "tests/support/scene_text.h"

namespace tallow {
namespace {

// Looking down on a penumbra that crosses the picture; a wall beside it reflects light onto it.
constexpr const char* kScene = R"(
cameras:
  main: {type: perspective, position: [0, 20, 0], look_at: [0, 0, 0], up: [0, 0, 1], fov_deg: 8, resolution: [1, 1]}
  fine: {type: perspective, position: [0, 20, 0], look_at: [0, 0, 0], up: [0, 0, 1], fov_deg: 8, resolution: [64, 64]}
materials:
  floor: {type: diffuse, reflectance: 0.5}
objects:
  - {shape: plane, point: [0, 0, 0], normal: [0, 1, 0], material: floor}
  - {shape: cube, center: [5, 1, 0], size: [10, 0.1, 40], material: floor}
  - {shape: cube, center: [-6, 2, 0], size: [0.2, 4, 4], material: floor}
lights:
  - {type: quad, position: [0, 30, 6], look_at: [0, 0, 0], size: [20, 20], radiance: 1}
settings: {tolerance: 0.01, bounces: BOUNCES}
)";

double mean_of_picture(const std::string& text, std::size_t camera, int samples) {
    Scene scene = scene_of(text.c_str());
    scene.settings.samples = samples;
    Stats stats;
    Progress quiet(true);
    const SceneGeometry geometry = load_geometry(scene, stats);
    const PreparedScene world(scene, geometry, CacheView{}, ExitanceAccuracy{}, {}, stats);
    const Camera& view = scene.cameras[camera];
    const Image image = render_image(world, view, {whole_image(view), samples, {}}, quiet, stats);
    const std::vector<float>& green = image.channels[1].values;
    return std::accumulate(green.begin(), green.end(), 0.0) / double(green.size());
}

TEST(PixelSampling, OneLargePixelIsTheMeanOfSmallOnes) {
    for (const char* bounces : {"0", "1"}) {
        std::string text = kScene;
        text.replace(text.find("BOUNCES"), 7, bounces);
        const double expected = mean_of_picture(text, 1, 1);
        EXPECT_NEAR(mean_of_picture(text, 0, 4096), expected, 0.01 * expected) << bounces;
    }
}

}  // namespace
}  // namespace tallow
