// SPDX-License-Identifier: Apache-2.0
// Caches from run to run: which a picture refuses, and what an interrupted or changed run keeps.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/cli/pyramid.h"
#include "tests/support/process.h"
#include "tests/support/test_files.h"

namespace tallow::test {
namespace {

class Refusal : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = pyramid_folder();
        make_cache(folder_);
    }

    void replace(const std::string& file, const std::string& from, const std::string& to) {
        std::string content = read_bytes(folder_ / file);
        const std::size_t at = content.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        content.replace(at, from.size(), to);
        write_bytes(folder_ / file, content);
    }

    // The cache is refused and the message names both values.
    void expect_refused(const std::string& made_from, const std::string& needed) {
        const Result result = render_to(folder_, "image.exr");
        EXPECT_EQ(result.exit_code, 3);
        EXPECT_NE(result.err.find(made_from), std::string::npos) << result.err;
        EXPECT_NE(result.err.find(needed), std::string::npos) << result.err;
        EXPECT_FALSE(std::filesystem::exists(folder_ / "image.exr"));
    }

    path folder_;
};

TEST_F(Refusal, ChangedMesh) {
    replace("pyramid.off", "0 7 0", "0 7.5 0");
    expect_refused("objects[0].mesh", "re-run tallow-precompute");
}

TEST_F(Refusal, MovedLight) {
    replace("scene.yaml", "position: [0, 15, 10]", "position: [0, 15, 11]");
    expect_refused("0 15 10", "0 15 11");
}

TEST_F(Refusal, ChangedEta) {
    replace("scene.yaml", "eta: 1.4", "eta: 1.35");
    expect_refused("1.4", "1.35");
}

TEST_F(Refusal, MovedObject) {
    replace("scene.yaml", "pyramid.off, material: stone",
            "pyramid.off, material: stone, transform: [{translate: [0, 1, 0]}]");
    expect_refused("objects[0]", "re-run tallow-precompute");
}

// Far more work than a second allows; Ctrl-C must end it with its exit code and leave nothing.
TEST(Pipeline, InterruptLeavesNothingBehind) {
    const path folder = pyramid_folder();
    make_cache(folder);
    // In the foreground, or it signals its group as well and the program gets two.
    const Result result =
        run("/usr/bin/timeout",
            {"--foreground", "--preserve-status", "--signal=INT", "1", TALLOW_RENDER,
             folder / "scene.yaml", "--cache", folder / "scene.tallow", "-o", folder / "image.exr",
             "--samples", "65536", "--quiet"});
    EXPECT_EQ(result.exit_code, 130);
    EXPECT_EQ(result.first_error_line(), "tallow-render: error: interrupted");
    EXPECT_FALSE(std::filesystem::exists(folder / "image.exr"));
    EXPECT_FALSE(std::filesystem::exists(folder / "image.exr.tmp"));
}

// However a run was stopped and wherever it was, going on gives the bytes of an undisturbed one.
TEST(Pipeline, ResumedCachesHaveTheSameBytes) {
    const path folder = pyramid_folder();
    const std::vector<std::string> work = {"--spacing", "0.12", "--light-samples", "32"};
    make_cache(folder, work);
    const std::string undisturbed = read_bytes(folder / "scene.tallow");
    for (const char* signal : {"KILL", "INT"})
        for (const char* seconds : {"0.1", "0.4"}) {
            std::filesystem::remove(folder / "scene.tallow");
            std::vector<std::string> interrupted = {"--foreground",
                                                    "--preserve-status",
                                                    fmt::format("--signal={}", signal),
                                                    seconds,
                                                    TALLOW_PRECOMPUTE,
                                                    folder / "scene.yaml",
                                                    "-o",
                                                    folder / "scene.tallow",
                                                    "--checkpoint-seconds",
                                                    "0"};
            interrupted.insert(interrupted.end(), work.begin(), work.end());
            const Result first = run("/usr/bin/timeout", interrupted);
            if (first.exit_code == 0) continue;  // a fast machine
            EXPECT_FALSE(std::filesystem::exists(folder / "scene.tallow"));
            std::vector<std::string> resumed = work;
            resumed.push_back("--resume");
            make_cache(folder, resumed);
            EXPECT_EQ(read_bytes(folder / "scene.tallow"), undisturbed) << signal << seconds;
            EXPECT_FALSE(std::filesystem::exists(folder / "scene.tallow.part"));
        }
}

// A cache that cannot be written costs no light: that is in the checkpoint. It is good for the same
// tolerance only, because numbers of rays follow from it and light of two kinds must not mix.
TEST(Pipeline, CheckpointOutlivesAFailedWrite) {
    const path folder = pyramid_folder();
    const auto make = [&](std::vector<std::string> flags) {
        flags.insert(flags.begin(), {folder / "scene.yaml", "-o", folder / "scene.tallow"});
        return precompute(flags);
    };
    std::filesystem::create_directory(folder / "scene.tallow.tmp");
    EXPECT_EQ(make({}).exit_code, 4);
    std::filesystem::remove(folder / "scene.tallow.tmp");
    ASSERT_TRUE(std::filesystem::exists(folder / "scene.tallow.part"));

    const Result other = make({"--spacing", "0.2", "--resume"});
    EXPECT_EQ(other.exit_code, 3);
    EXPECT_NE(other.err.find("checkpoint made from sampling.objects[0].spacing_mm"),
              std::string::npos)
        << other.err;
    const Result looser = make({"--tolerance", "0.5", "--resume"});
    EXPECT_EQ(looser.exit_code, 3);
    EXPECT_NE(looser.err.find("checkpoint made from sampling.tolerance = 0.1, but the scene has "
                              "sampling.tolerance = 0.5"),
              std::string::npos)
        << looser.err;

    const Result same = make({"--resume"});
    EXPECT_EQ(same.exit_code, 0) << same.err;
    EXPECT_EQ(same.err.find("\n0 sample results"), std::string::npos) << same.err;
    const std::string resumed = read_bytes(folder / "scene.tallow");
    make_cache(folder);
    EXPECT_EQ(read_bytes(folder / "scene.tallow"), resumed);
}

// A changed medium keeps the direct light; the result is that of a run from nothing.
TEST(Pipeline, ChangedMediumKeepsDirectLight) {
    const path folder = pyramid_folder();
    const std::vector<std::string> other = {"--spacing", "0.2", "--set",
                                            "materials.stone.sigma_a=[0.1, 0.1, 0.1]"};
    make_cache(folder, other);
    const std::string from_nothing = read_bytes(folder / "scene.tallow");
    make_cache(folder, {"--spacing", "0.2"});
    EXPECT_NE(read_bytes(folder / "scene.tallow"), from_nothing);
    std::vector<std::string> flags = {folder / "scene.yaml", "-o", folder / "scene.tallow"};
    flags.insert(flags.end(), other.begin(), other.end());
    const Result result = precompute(flags);
    EXPECT_NE(result.err.find("direct light kept"), std::string::npos) << result.err;
    EXPECT_EQ(read_bytes(folder / "scene.tallow"), from_nothing);
}

}  // namespace
}  // namespace tallow::test
