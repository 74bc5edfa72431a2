// SPDX-License-Identifier: Apache-2.0
// Animations, as a user renders them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "common/image/exr_io.h"
#include "tests/support/process.h"
#include "tests/support/test_files.h"

namespace tallow::test {
namespace {

using std::filesystem::path;

constexpr const char* kScene = R"(
cameras:
  still: {type: perspective, position: [3, 3, 7], look_at: [0, 0, 0], fov_deg: 30, resolution: [20, 16]}
  turn: {type: perspective, position: [3, 3, 7], look_at: [0, 0, 0], fov_deg: 30, resolution: [20, 16], turntable: {frames: 6}}
  long: {type: perspective, position: [3, 3, 7], look_at: [0, 0, 0], fov_deg: 30, resolution: [8, 8], turntable: {frames: 60000}}
  way:
    type: thin-lens
    aperture_mm: 0.6
    focus_at: [1, 0, 1]
    look_at: [0, 0, 0]
    fov_deg: 30
    resolution: [16, 20]
    keyframes: [{frame: 0, position: [3, 3, 7]}, {frame: 2, position: [7, 3, 3]}, {frame: 5, position: [7, 5, -3], fov_deg: 20}]
  through:
    type: perspective
    look_at: [0, 0.1, -20]
    fov_deg: 30
    resolution: [8, 8]
    keyframes: [{frame: 0, position: [0, 0, 7.5]}, {frame: 7, position: [0, 0, 0.5]}]
materials:
  wax: {type: subsurface, sigma_s_prime: [1, 1.5, 2], sigma_a: [0.02, 0.1, 0.3], eta: 1.4}
  floor: {type: diffuse, reflectance: 0.4}
objects:
  - {shape: cube, size: [3, 2, 2], material: wax}
  - {shape: plane, point: [0, -1.5, 0], normal: [0, 1, 0], material: floor}
lights:
  - {type: quad, position: [0, 6, -3], look_at: [0, 0, 0], size: [2, 2], radiance: 9}
settings: {samples: 2, light_samples: 4, bounces: 1, tolerance: 0.1, single_scattering_depths: 8}
)";

class Frames : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = fresh_folder();
        write_bytes(folder_ / "scene.yaml", kScene);
        const Result result = precompute({folder_ / "scene.yaml", "-o", folder_ / "scene.tallow",
                                          "--spacing", "0.3", "--quiet"});
        ASSERT_EQ(result.exit_code, 0) << result.err;
    }

    std::vector<std::string> command(const std::string& camera,
                                     const std::vector<std::string>& flags) const {
        std::vector<std::string> words = {folder_ / "scene.yaml",
                                          "--cache",
                                          folder_ / "scene.tallow",
                                          "--camera",
                                          camera,
                                          "--quiet"};
        words.insert(words.end(), flags.begin(), flags.end());
        return words;
    }

    void expect_rendered(const std::string& camera, const std::vector<std::string>& flags) const {
        const Result result = render(command(camera, flags));
        ASSERT_EQ(result.exit_code, 0) << result.err;
    }

    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(folder_))
            names.push_back(entry.path().filename());
        std::ranges::sort(names);
        return names;
    }

    std::string bytes(const std::string& name) const { return read_bytes(folder_ / name); }

    path folder_;
};

// Rendered together or alone, on one thread or many.
TEST_F(Frames, HaveTheBytesThatEachHasAlone) {
    for (const std::string camera : {"turn", "way"}) {
        const std::string together = folder_ / (camera + "_##.exr"),
                          picture = folder_ / (camera + "_##.png"), alone = folder_ / "alone.exr";
        expect_rendered(camera, {"--frames", "0-5", "--threads", "2", "--aovs", "all", "-o",
                                 together, "-o", picture});
        for (const int frame : {0, 3, 5}) {
            expect_rendered(camera, {"--frames", fmt::format("{}", frame), "--threads", "1",
                                     "--aovs", "all", "-o", alone, "-o", folder_ / "alone.png"});
            EXPECT_EQ(bytes(fmt::format("{}_{:02}.exr", camera, frame)), bytes("alone.exr"))
                << camera << frame;
            EXPECT_EQ(bytes(fmt::format("{}_{:02}.png", camera, frame)), bytes("alone.png"))
                << camera << frame;
            EXPECT_EQ(bytes(camera + "_00.png") == bytes("alone.png"), frame == 0);
        }
        expect_rendered(camera, {"--aovs", "all", "-o", alone});  // frame 0
        EXPECT_EQ(bytes(camera + "_00.exr"), bytes("alone.exr")) << camera;
    }
}

TEST_F(Frames, SayWhichTheyAre) {
    expect_rendered("turn", {"--frames", "4-5", "-o", folder_ / "a##b###.exr"});
    expect_rendered("turn", {"--frames", "3", "-o", folder_ / "#.exr"});
    EXPECT_EQ(files(), (std::vector<std::string>{"3.exr", "a04b004.exr", "a05b005.exr",
                                                 "scene.tallow", "scene.yaml"}));
    const auto metadata = read_exr(folder_ / "a05b005.exr").metadata;
    EXPECT_NE(std::ranges::find(metadata, std::pair<std::string, std::string>("tallow/frame", "5")),
              metadata.end());
}

TEST_F(Frames, StatsHaveTheTimeOfEach) {
    expect_rendered(
        "turn", {"--frames", "2-4", "-o", folder_ / "#.exr", "--stats", folder_ / "stats.json"});
    const std::string stats = bytes("stats.json");
    for (const char* part : {"\"frames\": [", "\"frame\": 2,", "\"frame\": 4,",
                             "\"camera_rays\": 1920"})  // 3 frames of 20 x 16 pixels, 2 rays
        EXPECT_NE(stats.find(part), std::string::npos) << part << '\n' << stats;
    EXPECT_EQ(stats.find("\"frame\": 5"), std::string::npos);
    expect_rendered("turn", {"-o", folder_ / "0.exr", "--stats", folder_ / "stats.json"});
    EXPECT_EQ(bytes("stats.json").find("\"frames\""), std::string::npos);
}

TEST_F(Frames, AreRefusedBeforeAnyWork) {
    struct Row {
        std::string camera, frames, output, message;
    };
    const std::string numbered = folder_ / "####.exr", plain = folder_ / "turn.exr";
    const std::vector<Row> rows = {
        {"turn", "0-3", plain,
         "--output: expected a name with #### for the number of the frame, as in turn_####.exr, "
         "got '" +
             plain + "'"},
        {"turn", "3-1", numbered,
         "--frames: expected a frame A or frames A-B, 0 <= A <= B, got '3-1'"},
        {"turn", "0-6", numbered, "--frames: expected frames 0 to 5 of camera 'turn', got 6"},
        {"way", "6", numbered, "--frames: expected frames 0 to 5 of camera 'way', got 6"},
        {"still", "0", numbered,
         "--frames: expected a camera with a turntable or keyframes, got 'still', which does not "
         "move"},
    };
    for (const Row& row : rows) {
        const Result result =
            render(command(row.camera, {"--frames", row.frames, "-o", row.output}));
        EXPECT_EQ(result.exit_code, 2) << row.message;
        EXPECT_EQ(result.first_error_line(), "tallow-render: usage: " + row.message);
    }
    EXPECT_EQ(files(), (std::vector<std::string>{"scene.tallow", "scene.yaml"}));
}

// The camera is outside in frame 6, at z = 1.5, and inside of the cube in frame 7.
TEST_F(Frames, CamerasMustNotMoveIntoBodies) {
    const Result result = render(command("through", {"--frames", "0-7", "-o", folder_ / "#.exr"}));
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_NE(result.err.find("camera 'through' is inside this translucent body in frame 7"),
              std::string::npos)
        << result.err;
    EXPECT_EQ(files(), (std::vector<std::string>{"scene.tallow", "scene.yaml"}));
}

// Ctrl-C once there is a first frame. What is there then is as each frame is alone.
TEST_F(Frames, AnInterruptionLeavesWholeFrames) {
    const path pictures = folder_ / "pictures";
    std::filesystem::create_directory(pictures);
    std::string words;
    for (const std::string& word :
         command("long", {"--frames", "0-59999", "-o", pictures / "#.exr"}))
        words += fmt::format("'{}' ", word);
    const Result result = run(
        "/bin/bash",
        {"-c", fmt::format("{} {} & while [ ! -e '{}' ] && kill -0 $!; do sleep 0.01; done; kill "
                           "-INT $!; wait $!",
                           TALLOW_RENDER, words, (pictures / "0.exr").string())});
    EXPECT_EQ(result.exit_code, 130) << result.err;
    EXPECT_EQ(result.first_error_line(), "tallow-render: error: interrupted");
    int frames = 0;
    for (const auto& entry : std::filesystem::directory_iterator(pictures)) {
        ASSERT_EQ(entry.path().extension(), ".exr") << entry.path();
        ++frames;
    }
    for (int frame = 0; frame < frames; frame += std::max(1, frames / 8)) {
        expect_rendered("long", {"--frames", fmt::format("{}", frame), "-o", folder_ / "1.exr"});
        EXPECT_EQ(read_bytes(pictures / fmt::format("{}.exr", frame)), bytes("1.exr")) << frame;
    }
}

TEST_F(Frames, ApertureOfZeroIsThePinhole) {
    expect_rendered("still", {"--aovs", "all", "-o", folder_ / "pinhole.exr"});
    const std::string lens =
        "cameras.still={type: thin-lens, position: [3, 3, 7], look_at: [0, 0, 0], fov_deg: 30, "
        "resolution: [20, 16], focus_mm: 7, aperture_mm: ";
    expect_rendered("still", {"--aovs", "all", "-o", folder_ / "closed.exr", "--set", lens + "0}"});
    EXPECT_EQ(bytes("closed.exr"), bytes("pinhole.exr"));
    expect_rendered("still", {"--aovs", "all", "-o", folder_ / "open.exr", "--set", lens + "1}"});
    EXPECT_NE(bytes("open.exr"), bytes("pinhole.exr"));
}

}  // namespace
}  // namespace tallow::test
