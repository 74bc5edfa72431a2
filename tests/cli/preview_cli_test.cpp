// SPDX-License-Identifier: Apache-2.0
// --preview, as a user sees it in tev.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/image/exr_io.h"
#include "tests/support/fake_tev.h"
#include "tests/support/process.h"
#include "tests/support/test_files.h"

namespace tallow::test {
namespace {

constexpr const char* kScene = R"(
cameras:
  main: {type: perspective, position: [3, 3, 7], look_at: [0, 0, 0], fov_deg: 30, resolution: [70, 50], turntable: {frames: 6}}
materials:
  floor: {type: diffuse, reflectance: 0.4}
objects:
  - {shape: sphere, radius: 1, material: floor}
lights:
  - {type: quad, position: [0, 6, -3], look_at: [0, 0, 0], size: [2, 2], radiance: 9}
settings: {samples: 2}
)";

class Preview : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = fresh_folder();
        write_bytes(folder_ / "scene.yaml", kScene);
    }
    std::vector<std::string> command(const std::vector<std::string>& flags) const {
        std::vector<std::string> words = {folder_ / "scene.yaml"};
        words.insert(words.end(), flags.begin(), flags.end());
        return words;
    }
    std::filesystem::path folder_;
};

TEST_F(Preview, HasThePixelsOfTheImage) {
    FakeTev tev;
    const std::string file = folder_ / "a.exr";
    const Result result = render(command({"-o", file, "--aovs", "diffuse,Z", "--crop", "3,2,70,41",
                                          "--preview", fmt::format("127.0.0.1:{}", tev.port())}));
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err.find("warning"), std::string::npos) << result.err;
    const auto images = tev.images();
    ASSERT_EQ(images.size(), 1u);
    ASSERT_TRUE(images.contains(file)) << images.begin()->first;
    const FakeTev::SentImage& sent = images.at(file);
    EXPECT_EQ(sent.width, 70);
    EXPECT_EQ(sent.height, 50);
    EXPECT_EQ(sent.updates, 6);  // tiles of 32 x 32 pixels
    const Image image = read_exr(file);
    ASSERT_EQ(sent.channels.size(), image.channels.size());
    for (const Channel& channel : image.channels)
        for (int y = 0; y < image.crop_height; ++y)
            for (int x = 0; x < image.crop_width; ++x)
                ASSERT_EQ(sent.channels.at(channel.name)[std::size_t((y + 2) * 70 + x + 3)],
                          channel.values[std::size_t(y * image.crop_width + x)])
                    << channel.name << ' ' << x << ' ' << y;
    EXPECT_EQ(sent.channels.at("A")[0], 0);  // outside of the crop nothing is sent
}

TEST_F(Preview, HasAnImageForEachFrame) {
    FakeTev tev;
    const Result result = render(command({"-o", folder_ / "#.png", "--frames", "1-2", "--preview",
                                          fmt::format("127.0.0.1:{}", tev.port())}));
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto images = tev.images();
    EXPECT_EQ(images.size(), 2u);
    EXPECT_TRUE(images.contains(folder_ / "1.png") && images.contains(folder_ / "2.png"));
}

TEST_F(Preview, IsMissedWithAWarning) {
    int port = 0;  // one that nobody listens to any more
    {
        FakeTev tev;
        port = tev.port();
        render(command({"-o", folder_ / "b.png", "--preview", fmt::format(":{}", port)}));
    }
    const Result result =
        render(command({"-o", folder_ / "a.png", "--preview", fmt::format("127.0.0.1:{}", port)}));
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.first_error_line(),
              fmt::format("tallow-render: warning: no preview: no tev listens at 127.0.0.1:{}: "
                          "Connection refused",
                          port));
    EXPECT_TRUE(std::filesystem::exists(folder_ / "a.png"));
}

TEST_F(Preview, RefusesWhatIsNoAddress) {
    for (const char* text : {"here:0", "here:70000", "here:14158x", "a/b", "[::1", "[::1]14158"}) {
        const Result result = render(command({"-o", folder_ / "a.png", "--preview", text}));
        EXPECT_EQ(result.exit_code, 2);
        EXPECT_EQ(
            result.first_error_line(),
            fmt::format("tallow-render: usage: --preview: expected HOST:PORT, got '{}'", text));
    }
    EXPECT_FALSE(std::filesystem::exists(folder_ / "a.png"));
}

}  // namespace
}  // namespace tallow::test
