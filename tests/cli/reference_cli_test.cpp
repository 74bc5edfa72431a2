// SPDX-License-Identifier: Apache-2.0
// tallow-reference as a user runs it.
#include <gtest/gtest.h>

#include <map>

#include "common/image/exr_io.h"
#include "tests/support/process.h"
#include "tests/support/test_files.h"

namespace tallow::test {
namespace {

Result reference(const std::vector<std::string>& arguments) {
    return run(TALLOW_REFERENCE, arguments);
}

std::filesystem::path write_scene() {
    const std::filesystem::path file = fresh_folder() / "ball.yaml";
    write_bytes(file, R"(
cameras:
  main: {type: perspective, position: [0, 0, 12], look_at: [0, 0, 0], fov_deg: 25, resolution: [6, 5]}
materials:
  stone: {type: subsurface, sigma_s_prime: 1, sigma_a: 2, eta: 1.4}
objects:
  - {shape: sphere, radius: 2, material: stone}
lights:
  - {type: quad, position: [9, 9, 9], look_at: [0, 0, 0], size: [4, 4], radiance: 5}
)");
    return file;
}

TEST(ReferenceCli, WritesLayersVarianceAndMetadata) {
    const std::filesystem::path scene = write_scene(), image = test_out("files/ref.exr");
    const Result result = reference({scene.string(), "-o", image.string(), "--paths", "1", "--set",
                                     "lights.0.radiance=7", "--quiet"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Image picture = read_exr(image);
    EXPECT_EQ(picture.width, 6);
    for (const char* name : {"R", "A", "single.G", "multi.B", "ext.R", "mirror.R", "variance.R",
                             "single_variance.G", "multi_variance.B", "ext_variance.R"})
        EXPECT_NE(picture.find_channel(name), nullptr) << name;
    EXPECT_GT((*picture.find_channel("multi.R"))[15], 0);
    std::map<std::string, std::string> said(picture.metadata.begin(), picture.metadata.end());
    EXPECT_EQ(said["tallow/set"], "lights.0.radiance=7");
    EXPECT_EQ(said["tallow/batches"], "16");
    EXPECT_TRUE(std::filesystem::exists(image.string() + ".checkpoint"));
}

TEST(ReferenceCli, SaysWhatIsWrong) {
    const std::string scene = write_scene().string(), image = test_out("files/ref.exr").string();
    Result result = reference({scene});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.first_error_line(),
              "tallow-reference: usage: --output: expected a name ending in .exr, got ''");
    result = reference({scene, "-o", image, "--estimator", "fast"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.first_error_line(),
              "tallow-reference: usage: --estimator: expected combined or camera, got 'fast'");
    result = reference({scene, "-o", image, "--camera", "top"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.first_error_line(),
              "tallow-reference: usage: --camera: expected one of main, got 'top'");
    result = reference({scene, "-o", image, "--set", "materials.stone={type: mirror}"});
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_EQ(result.first_error_line(),
              "tallow-reference: error: " + scene +
                  ":7:5: objects[0]: expected a subsurface material, got the opaque 'stone': the "
                  "reference knows translucent bodies only");
}

}  // namespace
}  // namespace tallow::test
