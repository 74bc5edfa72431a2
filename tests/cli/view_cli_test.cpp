// SPDX-License-Identifier: Apache-2.0
// tallow-view without a window: scripts, files, errors.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "common/image/exr_io.h"
#include "tests/support/process.h"
#include "tests/support/test_files.h"

namespace tallow::test {
namespace {

using std::filesystem::path;

constexpr const char* kScene = R"(
cameras:
  main: {type: perspective, position: [3, 3, 7], look_at: [0, 0, 0], fov_deg: 30, resolution: [40, 32]}
materials:
  wax: {type: subsurface, sigma_s_prime: [1, 1.5, 2], sigma_a: [0.02, 0.1, 0.3], eta: 1.4}
  floor: {type: diffuse, reflectance: 0.4}
objects:
  - {shape: cube, size: [3, 2, 2], material: wax}
  - {shape: plane, point: [0, -1.5, 0], normal: [0, 1, 0], material: floor}
lights:
  - {type: quad, position: [0, 6, -3], look_at: [0, 0, 0], size: [2, 2], radiance: 9, group: key}
settings: {samples: 4, light_samples: 4, indirect_samples: 4, bounces: 1, single_scattering_depths: 8}
)";

Result view(const std::vector<std::string>& arguments) { return run(TALLOW_VIEW, arguments); }

class Viewer : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = fresh_folder();
        write_bytes(folder_ / "scene.yaml", kScene);
    }

    /// Runs a script for some frames; fails the test if it does not end well.
    std::string replay(const std::string& script, int frames,
                       const std::vector<std::string>& flags = {}) {
        write_bytes(folder_ / "script.yaml", script);
        std::vector<std::string> words = {folder_ / "scene.yaml",
                                          "--script",
                                          folder_ / "script.yaml",
                                          "--frames",
                                          std::to_string(frames),
                                          "--screenshots",
                                          folder_,
                                          "--log",
                                          folder_ / "log.csv"};
        words.insert(words.end(), flags.begin(), flags.end());
        const Result result = view(words);
        EXPECT_EQ(result.exit_code, 0) << result.err;
        return result.err;
    }

    /// The frame log, row by row, by column.
    std::vector<std::map<std::string, std::string>> log() const {
        std::ifstream stream(folder_ / "log.csv");
        std::string line, cell;
        std::vector<std::string> names;
        std::vector<std::map<std::string, std::string>> rows;
        while (std::getline(stream, line)) {
            std::istringstream cells(line + ",");
            std::vector<std::string> values;
            while (std::getline(cells, cell, ',')) values.push_back(cell);
            if (names.empty()) {
                names = values;
                continue;
            }
            EXPECT_EQ(values.size(), names.size()) << line;
            rows.emplace_back();
            for (std::size_t i = 0; i < names.size(); ++i) rows.back()[names[i]] = values[i];
        }
        return rows;
    }

    bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

    path folder_;
};

double relative_error(const Image& a, const Image& b, const std::string& channel) {
    const auto &x = *a.find_channel(channel), &y = *b.find_channel(channel);
    double squares = 0, sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        squares += double(x[i] - y[i]) * double(x[i] - y[i]), sum += y[i];
    return std::sqrt(squares * double(x.size())) / sum;
}

// Walks, rests, saves; the camera that it saved gives tallow-render the same picture.
TEST_F(Viewer, RestsOnThePictureOfTheRenderer) {
    replay(R"(
- {frame: 1, key: D, down: true}
- {frame: 3, key: D, down: false}
- {frame: 4, button: left, down: true, at: [20, 16]}
- {frame: 5, move: [26, 20]}
- {frame: 5, button: left, down: false, at: [26, 20]}
- {frame: 10, key: F12}
)",
           12);
    ASSERT_TRUE(exists("scene.tallow"));  // made, because there was none
    ASSERT_TRUE(exists("scene_0001.png") && exists("scene_0001.exr") && exists("scene_0001.yaml"));
    const Image shown = read_exr(folder_ / "scene_0001.exr");
    EXPECT_NE(std::ranges::find(shown.metadata,
                                std::pair<std::string, std::string>("tallow/samples", "4")),
              shown.metadata.end());

    std::string scene = kScene, camera = read_bytes(folder_ / "scene_0001.yaml");
    scene.insert(scene.find("  main:"), camera.substr(camera.find('\n') + 1));
    write_bytes(folder_ / "pasted.yaml", scene);
    const Result result =
        render({folder_ / "pasted.yaml", "--cache", folder_ / "scene.tallow", "--camera",
                "view_0001", "-o", folder_ / "a.exr", "--aovs", "all"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Image rendered = read_exr(folder_ / "a.exr");
    ASSERT_EQ(shown.channels.size(), rendered.channels.size());
    for (const char* channel : {"R", "G", "B", "multiple.R", "exitance.B"})
        EXPECT_LT(relative_error(shown, rendered, channel), 0.01) << channel;  // the tolerance
    for (const char* channel : {"Z", "A", "single.G", "N.X"})
        EXPECT_LT(relative_error(shown, rendered, channel), 1e-5) << channel;
}

TEST_F(Viewer, LogsWhatItShows) {
    replay(R"(
- {frame: 2, key: W, down: true}
- {frame: 4, key: W, down: false}
- {frame: 6, key: "2"}
- {frame: 7, key: ","}
- {frame: 8, resize: [20, 10]}
)",
           14);
    const auto rows = log();
    ASSERT_EQ(rows.size(), 14u);
    const std::string kinds[] = {"draft", "pass",  "draft", "draft", "pass", "pass", "pass",
                                 "draft", "draft", "pass",  "pass",  "pass", "pass", "pass"};
    for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(rows[i].at("kind"), kinds[i]) << i;
    EXPECT_EQ(rows[1].at("z_mm"), "7");
    EXPECT_LT(std::stod(rows[3].at("z_mm")), std::stod(rows[2].at("z_mm")));
    EXPECT_EQ(rows[4].at("z_mm"), rows[13].at("z_mm"));
    EXPECT_EQ(rows[5].at("aov"), "beauty");
    EXPECT_EQ(rows[6].at("aov"), "multiple");
    EXPECT_EQ(rows[6].at("tolerance"), "0.01");
    EXPECT_EQ(rows[7].at("tolerance"), "0.005");
    EXPECT_EQ(rows[7].at("width"), "40");
    EXPECT_EQ(rows[8].at("width"), "20");
    EXPECT_EQ(rows[8].at("height"), "10");
    EXPECT_EQ(rows[12].at("samples"), "4");
    EXPECT_EQ(rows[13].at("samples"), "4");  // at rest
}

// Keys without a new pass one, each with its own picture; whatever the threads.
TEST_F(Viewer, WritesEachFrameTheSameEachTime) {
    const std::string script = R"(
- {frame: 2, key: "4"}
- {frame: 3, key: "1"}
- {frame: 3, key: "+"}
- {frame: 5, key: M}
- {frame: 7, key: Shift, down: true}
- {frame: 7, key: M}
- {frame: 9, key: "6"}
- {frame: 11, key: "7"}
- {frame: 11, key: "]"}
)";
    const std::string err = replay(script, 14, {"-o", folder_ / "a_##.png", "--threads", "2"});
    EXPECT_EQ(err.find("frame 7:"), std::string::npos) << err;
    replay(script, 14, {"-o", folder_ / "b_##.png", "--threads", "1"});
    std::map<std::string, int> pictures;
    for (int i = 0; i < 14; ++i) {
        const std::string a = read_bytes(folder_ / fmt::format("a_{:02}.png", i));
        EXPECT_EQ(a, read_bytes(folder_ / fmt::format("b_{:02}.png", i))) << i;
        ++pictures[a];
    }
    EXPECT_EQ(pictures.size(), 14u);
    EXPECT_NE(log()[9].at("largest_bound"), "");
    EXPECT_LE(std::stod(log()[9].at("largest_bound")), 0.0101);  // certified 1 % of the exact sum
}

TEST_F(Viewer, KeepsTheOldFrameInsideABody) {
    const std::string err = replay(R"(
- {frame: 1, key: Shift, down: true}
- {frame: 1, key: W, down: true}
- {frame: 12, key: W, down: false}
)",
                                   14, {"--set", "cameras.main.position=[0, 0, 3]"});
    EXPECT_NE(err.find("inside this translucent body"), std::string::npos) << err;
    EXPECT_EQ(log().size(), 14u);
}

TEST_F(Viewer, EndsWhenItIsClosed) {
    replay("[{frame: 3, close: true}]", 100);
    EXPECT_EQ(log().size(), 3u);
}

// 2000 moves around the body; what the first two hundred need is what all need.
TEST_F(Viewer, DoesNotGrow) {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the address sanitizer keeps what was freed";
#endif
    std::string script = "- {frame: 0, button: left, down: true, at: [12, 10]}\n";
    for (int i = 1; i < 2000; ++i)
        script += fmt::format("- {{frame: {}, move: [{}, {}]}}\n", i, 2 * i, i % 7);
    replay(script, 2000, {"--set", "cameras.main.resolution=[24, 20]"});
    const auto rows = log();
    ASSERT_EQ(rows.size(), 2000u);
    for (std::size_t i = 1; i < rows.size(); ++i) {
        ASSERT_EQ(rows[i].at("kind"), "draft");
        ASSERT_GT(std::stod(rows[i].at("shading_points")), 20);
    }
    const double early = std::stod(rows[200].at("rss_mb")),
                 late = std::stod(rows[1999].at("rss_mb"));
    EXPECT_LT(late, early + 2) << "MB";
}

TEST_F(Viewer, RefusesWhatItCannotDo) {
    const std::string scene = folder_ / "scene.yaml", script = folder_ / "s.yaml";
    write_bytes(script, "- {frame: 0, key: X}");
    write_bytes(folder_ / "broken.yaml", "cameras: 3");
    write_bytes(folder_ / "broken.tallow", "no cache");
    struct Row {
        std::vector<std::string> words;
        int exit_code;
        std::string line;
    };
    const std::vector<Row> rows = {
        {{scene, "--script", script}, 2, "usage: --script: expected --frames beside it, got none"},
        {{scene, "-o", "a.png"}, 2, "usage: --output: expected --frames beside it, got none"},
        {{scene, "--frames", "2", "-o", "a.png"},
         2,
         "usage: --output: expected a name with #### for the number of the frame, as in "
         "turn_####.png, got 'a.png'"},
        {{scene, "--frames", "0"},
         2,
         "usage: --frames: expected an integer in [1, 1000000], got '0'"},
        {{scene, "--frames", "1", "--camera", "back"},
         2,
         "usage: --camera: expected one of main, got 'back'"},
        {{scene, "--frames", "1", "--tolerance", "0"},
         2,
         "usage: --tolerance: expected a number in [1e-4, 1), got '0'"},
        {{folder_ / "broken.yaml", "--frames", "1"},
         3,
         "error: " + (folder_ / "broken.yaml").string() +
             ":1:10: cameras: expected a map, got '3'"},
        {{folder_ / "none.yaml", "--frames", "1"},
         3,
         "error: " + (folder_ / "none.yaml").string() +
             ": cannot be read: No such file or directory"},
        {{scene, "--frames", "1", "--cache", folder_ / "none" / "a.tallow"}, 4, ""},
        {{scene, "--frames", "1", "--cache", folder_ / "broken.tallow"}, 3, ""},
        {{scene, "--frames", "1", "--script", folder_ / "none.yaml"}, 3, ""},
        {{scene, "--frames", "1", "--log", folder_ / "none" / "log.csv"},
         4,
         "error: " + (folder_ / "none" / "log.csv").string() + ": cannot be written"},
        {{scene, "--frames", "1", "-o", folder_ / "none" / "a.png"}, 4, ""},
    };
    for (const Row& row : rows) {
        std::vector<std::string> words = row.words;
        words.push_back("--quiet");
        const Result result = view(words);
        EXPECT_EQ(result.exit_code, row.exit_code) << result.err;
        const std::string line = "tallow-view: " + row.line;
        EXPECT_EQ(result.first_error_line().substr(0, line.size()), line);
    }
    const Result unknown_key = view({scene, "--frames", "1", "--script", script});
    EXPECT_EQ(unknown_key.exit_code, 3);
    EXPECT_NE(unknown_key.err.find("s.yaml:1:19: key: expected one of W A S D"), std::string::npos)
        << unknown_key.err;
}

TEST_F(Viewer, SaysSoWithoutADisplay) {
    const Result result =
        run("/usr/bin/env", {"-u", "DISPLAY", "-u", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER=x11",
                             TALLOW_VIEW, folder_ / "scene.yaml"});
    EXPECT_EQ(result.exit_code, 4);
    EXPECT_TRUE(result.first_error_line().starts_with("tallow-view: error: cannot open a window: "))
        << result.err;
    EXPECT_NE(result.first_error_line().find("; --frames with --script needs no display"),
              std::string::npos);
}

}  // namespace
}  // namespace tallow::test
