// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/image/exr_io.h"
#include "tests/support/process.h"
#include "tests/support/test_files.h"

namespace tallow::test {

using std::filesystem::path;

// A pyramid over a square; four-cornered base, outward.
inline constexpr const char* kPyramid =
    "OFF\n5 5 0\n-4 0 -4\n4 0 -4\n4 0 4\n-4 0 4\n0 7 0\n4 0 1 2 3\n3 4 3 2\n3 4 2 1\n3 4 1 0\n3 4 "
    "0 3\n";

inline constexpr const char* kPyramidScene = R"(
cameras:
  main: {type: perspective, position: [9, 8, 14], look_at: [0, 2.5, 0], fov_deg: 40, resolution: [48, 40]}
  above: {type: perspective, position: [1, 20, 6], look_at: [0, 2.5, 0], fov_deg: 40, resolution: [32, 32]}
materials:
  stone: {type: subsurface, sigma_s_prime: [1, 1.2, 1.5], sigma_a: [0.01, 0.05, 0.2], eta: 1.4}
  floor: {type: diffuse, reflectance: 0.4}
  coat: {type: plastic, reflectance: [0.5, 0.1, 0.1]}
  silver: {type: mirror, reflectance: 0.9}
objects:
  - {shape: mesh, file: pyramid.off, material: stone}
  - {shape: plane, point: [0, 0, 0], normal: [0, 1, 0], material: floor}
  - {shape: sphere, center: [-6, 2, 3], radius: 2, material: coat}
  - {shape: disc, center: [0, 6, -9], normal: [0, 0, 1], radius: 5, material: silver}
lights:
  - {type: quad, position: [-8, 14, -6], look_at: [0, 3, 0], size: [6, 6], radiance: [9, 8, 7], group: key}
  - {type: sphere, position: [9, 12, 4], radius: 1.5, radiance: 12, group: key}
  - {type: point, position: [0, 15, 10], intensity: 60}
  - {type: spot, position: [5, 15, 0], look_at: [0, 0, 0], intensity: 90, cone_deg: 30}
  - {type: directional, direction: [1, -2, -1], irradiance: 0.2}
  - {type: environment, radiance: [0.05, 0.06, 0.08], group: sky}
settings: {samples: 4, light_samples: 8, tolerance: 0.1, bounces: 1, single_scattering_depths: 8}
)";

inline path pyramid_folder(const std::string& part = "files") {
    const path folder = fresh_folder(part);
    write_bytes(folder / "pyramid.off", kPyramid);
    write_bytes(folder / "scene.yaml", kPyramidScene);
    return folder;
}

inline void make_cache(const path& folder, std::vector<std::string> flags = {}) {
    flags.insert(flags.begin(),
                 {(folder / "scene.yaml").string(), "-o", (folder / "scene.tallow").string()});
    const Result result = precompute(flags);
    ASSERT_EQ(result.exit_code, 0) << result.err;
}

inline Result render_to(const path& folder, const std::string& image,
                        std::vector<std::string> flags = {}) {
    flags.insert(flags.begin(),
                 {(folder / "scene.yaml").string(), "--cache", (folder / "scene.tallow").string(),
                  "-o", (folder / image).string(), "--quiet"});
    return render(flags);
}

inline std::vector<float> channel(const path& file, const std::string& name) {
    const Image image = read_exr(file);
    const std::vector<float>* values = image.find_channel(name);
    EXPECT_NE(values, nullptr) << name;
    return values ? *values : std::vector<float>{};
}

}  // namespace tallow::test
