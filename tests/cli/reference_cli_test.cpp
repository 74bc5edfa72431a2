// SPDX-License-Identifier: Apache-2.0
// tallow-reference as a user runs it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <sstream>

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

/// Power in red by event.
std::map<std::string, double> balance(const std::vector<std::string>& overrides) {
    std::vector<std::string> arguments{write_scene().string(), "--paths", "1e5", "--quiet"};
    for (const std::string& change : overrides)
        arguments.insert(arguments.end(), {"--set", change});
    const Result result = run(TALLOW_REFERENCE_BALANCE, arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    std::map<std::string, double> power;
    std::istringstream lines(result.out);
    for (std::string line; std::getline(lines, line);)
        if (const std::size_t comma = line.find(','); line.rfind("event", 0) != 0)
            power[line.substr(0, comma)] = std::strtod(line.c_str() + comma + 1, nullptr);
    return power;
}

// Light that nothing absorbs leaves a ball as it entered; only what was never scattered (e^-20 of
// it) is not counted. A ball does not see itself.
TEST(ReferenceBalance, WhiteBallLetsOutAllThatEnters) {
    const auto power = balance({"materials.stone.sigma_a=0", "materials.stone.sigma_s_prime=5"});
    const double entered = power.at("entered_first");
    EXPECT_GT(entered, 0);
    EXPECT_NEAR((power.at("left_once") + power.at("left_more")) / entered, 1, 2e-4);
    EXPECT_EQ(power.at("entered_bare") + power.at("entered_second") + power.at("left_second"), 0);
}

TEST(ReferenceBalance, OfNoLightIsNothing) {
    for (const auto& [event, power] : balance({"lights=[]"})) EXPECT_EQ(power, 0) << event;
    const Result result = run(TALLOW_REFERENCE_BALANCE, {write_scene().string(), "--paths", "0"});
    EXPECT_EQ(result.exit_code, 2);
}

// Of two balls side by side each lights the other: what enters later is less than what left before.
TEST(ReferenceBalance, BallsLightEachOther) {
    const auto power =
        balance({"materials.stone.sigma_a=0",
                 "objects=[{shape: sphere, radius: 2, material: stone}, "
                 "{shape: sphere, radius: 2, center: [4.1, 0, 0], material: stone}]"});
    const double left = power.at("left_once") + power.at("left_more");
    EXPECT_GT(power.at("entered_second"), 0.01 * left);
    EXPECT_LT(power.at("entered_second"), 0.5 * left);
    EXPECT_GT(power.at("entered_bare"), 0);
    EXPECT_GT(power.at("entered_later"), 0);
    EXPECT_LT(power.at("entered_later"), power.at("entered_second"));
    EXPECT_NEAR(power.at("left_second") / power.at("entered_second"), 1, 0.02);
}

}  // namespace
}  // namespace tallow::test
