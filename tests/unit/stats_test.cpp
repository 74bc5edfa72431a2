// SPDX-License-Identifier: Apache-2.0
#include "common/base/stats.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/errors.h"
#include "tests/support/error_text.h"
#include "tests/support/test_files.h"

namespace tallow {
namespace {

nlohmann::json written(const Stats& stats) {
    const std::filesystem::path file = test_out("stats.json");
    write_stats(file, stats);
    return nlohmann::json::parse(std::ifstream(file));
}

TEST(Stats, WritesSixSections) {
    Stats stats = make_stats("tallow-test", 2);
    stats.seconds["load"] = 0.25;
    stats.counts["samples"] = std::int64_t{1} << 40;
    stats.counts["mesh"] = "bunny.ply";
    stats.errors["bound"] = 0.5;
    stats.plan.decisions = {{"scene", "indirect light", false, "0 bounces", "forced", {}},
                            {"objects[0]", "samples", false, "diffuse", "small", 0.25}};
    stats.plan.numbers["samples"] = 7;
    const nlohmann::json json = written(stats);
    EXPECT_EQ(json["plan"]["numbers"]["samples"], 7);
    EXPECT_EQ(json["plan"]["decisions"][0]["term"], "indirect light");
    EXPECT_FALSE(json["plan"]["decisions"][0].contains("bound"));
    EXPECT_EQ(json["plan"]["decisions"][1]["bound"], 0.25);
    EXPECT_EQ(json.size(), 6u);
    EXPECT_EQ(json["tool"], "tallow-test");
    EXPECT_EQ(json["seconds"], (nlohmann::json{{"load", 0.25}}));
    EXPECT_EQ(json["counts"]["samples"], std::int64_t{1} << 40);
    EXPECT_TRUE(json["counts"]["samples"].is_number_integer());
    EXPECT_EQ(json["counts"]["mesh"], "bunny.ply");
    EXPECT_EQ(json["errors"]["bound"], 0.5);
    EXPECT_EQ(json["versions"]["tallow"], "0.1.0");
    EXPECT_EQ(json["versions"]["threads"], "2");
    for (const char* key : {"compiler", "isa", "build_type", "fmt", "glm", "tbb"})
        EXPECT_FALSE(json["versions"].at(key).get<std::string>().empty()) << key;
}

TEST(Stats, EmptySectionsAreObjects) {
    const nlohmann::json json = written(Stats{});
    for (const char* section : {"seconds", "counts", "errors", "versions"})
        EXPECT_EQ(json[section], nlohmann::json::object()) << section;
}

TEST(Stats, ListsFramesOfAnimations) {
    Stats stats;
    stats.frames = {{3, 0.5}, {4, 0.25}};
    EXPECT_EQ(written(stats)["frames"], (nlohmann::json{{{"frame", 3}, {"seconds", 0.5}},
                                                        {{"frame", 4}, {"seconds", 0.25}}}));
}

TEST(Stats, CountsAddUp) {
    Stats stats;
    add_count(stats, "rays", std::int64_t{1} << 40);
    add_count(stats, "rays", 3);
    EXPECT_EQ(std::get<std::int64_t>(stats.counts["rays"]), (std::int64_t{1} << 40) + 3);
}

TEST(Stats, SurvivesTextThatIsNotUtf8) {
    Stats stats;
    stats.counts["mesh"] = "\xff\xfe.ply";
    EXPECT_EQ(written(stats)["counts"]["mesh"], "\uFFFD\uFFFD.ply");
}

TEST(Stats, ReportsWhatCannotBeWritten) {
    EXPECT_EQ(error_text<OutputError>([] { write_stats("missing/s.json", Stats{}); }),
              "missing/s.json: cannot be written: No such file or directory");
}

TEST(PhaseTimer, AddsItsTimeOnce) {
    Stats stats;
    stats.seconds["load"] = 100;
    {
        PhaseTimer timer(stats, "load");
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        timer.stop();
        const double stopped = stats.seconds["load"];
        EXPECT_GE(stopped, 100.005 - 1e-9);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        timer.stop();
        EXPECT_EQ(stats.seconds["load"], stopped);
    }
    EXPECT_LT(stats.seconds["load"], 110);
}

}  // namespace
}  // namespace tallow
