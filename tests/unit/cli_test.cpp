// SPDX-License-Identifier: Apache-2.0
#include "common/base/cli.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/base/errors.h"
#include "tests/support/error_text.h"

namespace tallow {
namespace {

/// A command line with one flag of each kind.
struct Tool {
    std::filesystem::path scene, extra;
    bool plan = false;
    std::string camera = "main";
    std::vector<std::string> overrides;
    std::optional<std::filesystem::path> output;
    std::optional<double> tolerance = 0.01;
    std::optional<int> samples;
    CommonOptions common;

    bool parse(std::vector<const char*> arguments) {
        CommandLine line("tallow-test", "Tests.");
        line.positional("SCENE", scene, "scene file");
        line.positional("EXTRA", extra, "another file", false);
        line.flag("--plan", plan, "print the plan");
        line.text("--camera", camera, "camera to use", "NAME");
        line.text_list("--set", overrides, "override a value", "KEY=VALUE");
        line.path("-o,--output", output, "image to write");
        line.number("--spacing-mm", tolerance, 0, 10, "a number in [0, 10]", "spacing in mm");
        line.integer("--samples", samples, 1, 64, "an integer in [1, 64]", "rays a pixel");
        line.add_common(common);
        arguments.insert(arguments.begin(), "tallow-test");
        return line.parse(static_cast<int>(arguments.size()), arguments.data());
    }
};

std::string usage_error(const std::vector<const char*>& arguments) {
    return error_text<UsageError>([&] { Tool().parse(arguments); });
}

TEST(Cli, ReadsEveryKindOfFlag) {
    Tool tool;
    ASSERT_TRUE(tool.parse({"a.yaml", "--plan", "--camera", "top", "--set", "a=[1,2]", "-o",
                            "x.exr", "--spacing-mm", "2.5", "--set", "b.c=3", "--samples=8",
                            "--threads", "2", "-q", "--stats", "s.json"}));
    EXPECT_EQ(tool.scene, "a.yaml");
    EXPECT_TRUE(tool.extra.empty());
    EXPECT_TRUE(tool.plan);
    EXPECT_EQ(tool.camera, "top");
    EXPECT_EQ(tool.overrides, (std::vector<std::string>{"a=[1,2]", "b.c=3"}));
    EXPECT_EQ(tool.output, "x.exr");
    EXPECT_EQ(tool.tolerance, 2.5);
    EXPECT_EQ(tool.samples, 8);
    EXPECT_EQ(tool.common.threads, 2);
    EXPECT_TRUE(tool.common.quiet);
    EXPECT_EQ(tool.common.stats, "s.json");
}

TEST(Cli, KeepsDefaultsOfAbsentFlags) {
    Tool tool;
    ASSERT_TRUE(tool.parse({"a.yaml"}));
    EXPECT_FALSE(tool.plan);
    EXPECT_EQ(tool.camera, "main");
    EXPECT_EQ(tool.tolerance, 0.01);
    EXPECT_FALSE(tool.samples.has_value());
    EXPECT_FALSE(tool.output.has_value());
    EXPECT_EQ(tool.common.threads, 0);
    EXPECT_FALSE(tool.common.stats.has_value());
}

TEST(Cli, TakesArgumentsAfterTwoDashesAsFiles) {
    Tool tool;
    ASSERT_TRUE(tool.parse({"--plan", "--", "a.yaml"}));
    EXPECT_EQ(tool.scene, "a.yaml");
}

TEST(Cli, RefusesWhatItCannotRead) {
    const std::vector<std::pair<std::vector<const char*>, std::string>> rows = {
        {{}, "SCENE is required"},
        {{"--frob"}, "unknown flag '--frob', see --help"},
        {{"a.yaml", "-x"}, "unknown flag '-x', see --help"},
        {{"a.yaml", "b", "c"}, "unexpected argument 'c', see --help"},
        {{"a.yaml", "--samples"}, "--samples: missing value"},
        {{"a.yaml", "-o"}, "-o: missing value"},
        {{"a.yaml", "-o", "--plan"}, "--output: expected FILE, got '--plan'"},
        {{"a.yaml", "-o", ""}, "--output: expected FILE, got ''"},
        {{"a.yaml", "--camera", ""}, "--camera: expected NAME, got ''"},
        {{"a.yaml", "--plan", "--plan"}, "--plan: given 2 times"},
        {{"a.yaml", "-q", "--quiet", "-q"}, "--quiet: given 3 times"},
        {{"a.yaml", "--plan=no"}, "--plan: takes no value, got 'no'"},
        {{"a.yaml", "--plan=false"}, "--plan: takes no value, got 'false'"},
        {{"a.yaml", "-o", "x", "--output", "y"}, "--output: given 2 times"},
        {{"a.yaml", "--samples", "8", "--samples", "9"}, "--samples: given 2 times"},
        {{"a.yaml", "--samples", "0.5"}, "--samples: expected an integer in [1, 64], got '0.5'"},
        {{"a.yaml", "--samples", "8x"}, "--samples: expected an integer in [1, 64], got '8x'"},
        {{"a.yaml", "--samples", "0"}, "--samples: expected an integer in [1, 64], got '0'"},
        {{"a.yaml", "--samples", "99999999999"},
         "--samples: expected an integer in [1, 64], got '99999999999'"},
        {{"a.yaml", "--samples", "[4]"}, "--samples: expected an integer in [1, 64], got '[4]'"},
        {{"a.yaml", "--threads", "0"}, "--threads: expected an integer in [1, 1024], got '0'"},
        {{"a.yaml", "--spacing-mm", "1.5mm"},
         "--spacing-mm: expected a number in [0, 10], got '1.5mm'"},
        {{"a.yaml", "--spacing-mm", "-1"}, "--spacing-mm: expected a number in [0, 10], got '-1'"},
        {{"a.yaml", "--spacing-mm", "nan"},
         "--spacing-mm: expected a number in [0, 10], got 'nan'"},
        {{"a.yaml", "--spacing-mm", " 1"}, "--spacing-mm: expected a number in [0, 10], got ' 1'"},
    };
    for (const auto& [arguments, message] : rows) EXPECT_EQ(usage_error(arguments), message);
}

TEST(Cli, HelpGoesToStdoutWithUnitsAndDefaults) {
    testing::internal::CaptureStdout();
    EXPECT_FALSE(Tool().parse({"--help"}));
    std::fflush(stdout);
    const std::string help = testing::internal::GetCapturedStdout();
    EXPECT_NE(help.find("Usage: tallow-test [OPTIONS] SCENE [EXTRA]"), std::string::npos) << help;
    EXPECT_NE(help.find("--spacing-mm NUMBER=0.01"), std::string::npos) << help;
    EXPECT_NE(help.find("spacing in mm; a number in [0, 10]"), std::string::npos) << help;
    EXPECT_NE(help.find("--camera NAME=main"), std::string::npos) << help;
    EXPECT_NE(help.find("override a value; may be repeated"), std::string::npos) << help;
}

TEST(Cli, VersionNamesTheTool) {
    testing::internal::CaptureStdout();
    EXPECT_FALSE(Tool().parse({"--version"}));
    std::fflush(stdout);
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "tallow-test 0.1.0\n");
}

TEST(Cli, ParseNumberIsWholeFiniteAndInRange) {
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(parse_number("--x", "1e-3", 0, 1, "a number"), 1e-3);
    EXPECT_EQ(parse_number("--x", "-2", -infinity, infinity, "a number"), -2);
    for (const char* text : {"", "1,5", "0x10", "inf", "1e999", "1 2", "--1"})
        EXPECT_EQ(error_text<UsageError>(
                      [&] { parse_number("--x", text, -infinity, infinity, "a number"); }),
                  std::string("--x: expected a number, got '") + text + "'");
}

}  // namespace
}  // namespace tallow
