// SPDX-License-Identifier: Apache-2.0
// What a checkpoint keeps comes back to the bit, and nothing else does.
#include "precompute/checkpoint.h"

#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "tests/support/test_files.h"

namespace tallow {
namespace {

using Stage = Checkpoint::Stage;

constexpr std::size_t kSamples = 100;

std::vector<GroupIrradiance> light(float level) {
    std::vector<GroupIrradiance> groups(2);
    for (std::size_t g = 0; g < 2; ++g)
        for (std::size_t i = 0; i < kSamples; ++i) {
            groups[g].E_t.emplace_back(level + float(i), level * float(g), 0.1f);
            groups[g].w_i.emplace_back(0, level / 1000, float(i) / 1000);
        }
    return groups;
}

std::vector<GroupIrradiance> dark() {
    return {2, {std::vector<Rgb>(kSamples, Rgb(0)), std::vector<Vec3>(kSamples, Vec3(0))}};
}

const Fingerprint kScene = {{"objects", "1"}, {"sampling.light_samples", "16"}};

/// A run that is killed after two records: they are in the file, and it was not finished.
std::filesystem::path interrupted_run(const std::string& name) {
    const std::filesystem::path file = test_out(name);
    std::filesystem::remove(file);
    Checkpoint checkpoint(file, kScene, {.resume = false, .seconds = 0});
    checkpoint.keep(Stage::direct, 0, 0, 64, light(1));
    checkpoint.keep(Stage::surfaces, 3, 64, kSamples, light(2));
    return file;
}

bool same(const GroupIrradiance& a, const GroupIrradiance& b, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
        if (a.E_t[i] != b.E_t[i] || a.w_i[i] != b.w_i[i]) return false;
    return true;
}

TEST(Checkpoint, RestoresWhatWasKept) {
    const auto file = interrupted_run("restores.part");
    Checkpoint checkpoint(file, kScene, {.resume = true, .seconds = 0});
    auto groups = dark();
    EXPECT_FALSE(checkpoint.restore(Stage::direct, 1, 0, 64, groups));
    EXPECT_FALSE(checkpoint.restore(Stage::direct, 0, 0, 32, groups));
    EXPECT_FALSE(checkpoint.restore(Stage::bodies, 3, 64, kSamples, groups));
    ASSERT_TRUE(checkpoint.restore(Stage::direct, 0, 0, 64, groups));
    ASSERT_TRUE(checkpoint.restore(Stage::surfaces, 3, 64, kSamples, groups));
    for (std::size_t g = 0; g < 2; ++g) {
        EXPECT_TRUE(same(groups[g], light(1)[g], 0, 64));
        EXPECT_TRUE(same(groups[g], light(2)[g], 64, kSamples));
    }
    EXPECT_EQ(checkpoint.restored_samples(), kSamples);
}

TEST(Checkpoint, GoesOnInTheSameFile) {
    const auto file = interrupted_run("goes_on.part");
    {
        Checkpoint second(file, kScene, {.resume = true, .seconds = 0});
        second.keep(Stage::bodies, 0, 0, 64, light(3));  // nothing restored yet, and killed again
    }
    Checkpoint third(file, kScene, {.resume = true, .seconds = 0});
    auto groups = dark();
    EXPECT_TRUE(third.restore(Stage::direct, 0, 0, 64, groups));
    EXPECT_TRUE(third.restore(Stage::surfaces, 3, 64, kSamples, groups));
    EXPECT_TRUE(third.restore(Stage::bodies, 0, 0, 64, groups));
}

TEST(Checkpoint, FinishRemovesTheFile) {
    const auto file = interrupted_run("finished.part");
    Checkpoint(file, kScene, {.resume = true, .seconds = 0}).finish();
    EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(Checkpoint, ShortRunsDoNotTouchTheDisk) {
    const auto file = test_out("short.part");
    std::filesystem::remove(file);
    Checkpoint checkpoint(file, kScene, {.resume = false, .seconds = 1e6});
    checkpoint.keep(Stage::direct, 0, 0, 64, light(1));
    EXPECT_FALSE(std::filesystem::exists(file));
    checkpoint.finish();
    EXPECT_FALSE(std::filesystem::exists(file));
}

std::string resume_error(const std::filesystem::path& file, const Fingerprint& scene) {
    try {
        Checkpoint checkpoint(file, scene, {.resume = true, .seconds = 0});
        return "ok";
    } catch (const InputError& error) {
        return std::string(error.what()).substr(file.string().size());
    }
}

TEST(Checkpoint, RefusesOtherWork) {
    const auto file = interrupted_run("other.part");
    EXPECT_EQ(resume_error(file, {{"objects", "1"}, {"sampling.light_samples", "4"}}),
              ": checkpoint made from sampling.light_samples = 16, but the scene has "
              "sampling.light_samples = 4; run without --resume to begin anew");
    EXPECT_EQ(resume_error(file, {{"objects", "1"}}),
              ": checkpoint made from sampling.light_samples = 16, but the scene has nothing; run "
              "without --resume to begin anew");
    write_bytes(file, "TALLOWP1 of some sort");
    EXPECT_EQ(resume_error(file, kScene),
              ": expected a checkpoint of this version; run without --resume to begin anew");
    std::filesystem::remove(file);
    EXPECT_EQ(resume_error(file, kScene), "ok");  // nothing to go on from: begins
}

// Wherever a crash or a bad disk cuts or changes the file, what comes back is right.
TEST(Checkpoint, DamageCostsWorkButNeverBits) {
    const auto file = interrupted_run("damaged.part");
    const std::string good = read_bytes(file);
    const auto direct = light(1), surfaces = light(2);
    for (std::size_t place = 0; place < good.size(); place += 37)
        for (const bool cut : {true, false}) {
            std::string bytes = good;
            if (cut)
                bytes.resize(place);
            else
                bytes[place] = char(bytes[place] ^ 0x10);
            write_bytes(file, bytes);
            try {
                Checkpoint checkpoint(file, kScene, {.resume = true, .seconds = 1e6});
                auto groups = dark();
                const bool first = checkpoint.restore(Stage::direct, 0, 0, 64, groups);
                const bool second = checkpoint.restore(Stage::surfaces, 3, 64, kSamples, groups);
                for (std::size_t g = 0; g < 2; ++g) {
                    EXPECT_TRUE(!first || same(groups[g], direct[g], 0, 64)) << place;
                    EXPECT_TRUE(!second || same(groups[g], surfaces[g], 64, kSamples)) << place;
                }
            } catch (const InputError&) {
            }
        }
}

}  // namespace
}  // namespace tallow
