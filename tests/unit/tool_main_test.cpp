// SPDX-License-Identifier: Apache-2.0
#include "common/base/tool_main.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "tests/support/test_files.h"

namespace tallow {
namespace {

struct Outcome {
    int exit_code;
    std::string message;  // all of stderr
};

Outcome run(std::vector<std::string> arguments, const std::function<void(ToolRun&)>& body) {
    arguments.insert(arguments.begin(), "tallow-test");
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    testing::internal::CaptureStderr();
    const int exit_code = tool_main(
        "tallow-test", "Tests.", static_cast<int>(argv.size()), argv.data(), [](CommandLine&) {},
        body);
    return {exit_code, testing::internal::GetCapturedStderr()};
}

template <class Error>
Outcome run_throwing(const Error& error) {
    return run({}, [&](ToolRun&) { throw error; });
}

TEST(ToolMain, TurnsEachErrorIntoItsLineAndExitCode) {
    const std::vector<std::pair<Outcome, Outcome>> rows = {
        {run({}, [](ToolRun&) {}), {0, ""}},
        {run({"--frob"}, [](ToolRun&) {}),
         {2, "tallow-test: usage: unknown flag '--frob', see --help\n"}},
        {run_throwing(UsageError("no")), {2, "tallow-test: usage: no\n"}},
        {run_throwing(InputError("a.yaml:1:1: no")), {3, "tallow-test: error: a.yaml:1:1: no\n"}},
        {run_throwing(OutputError("full")), {4, "tallow-test: error: full\n"}},
        {run_throwing(Interrupted()), {130, "tallow-test: error: interrupted\n"}},
        {run_throwing(std::logic_error("bug")), {1, "tallow-test: internal error: bug\n"}},
    };
    for (const auto& [got, expected] : rows) {
        EXPECT_EQ(got.exit_code, expected.exit_code) << expected.message;
        EXPECT_EQ(got.message, expected.message);
    }
}

TEST(ToolMain, DoesNotRunTheBodyForHelp) {
    testing::internal::CaptureStdout();
    const Outcome outcome = run({"--help"}, [](ToolRun&) { FAIL() << "ran"; });
    EXPECT_NE(testing::internal::GetCapturedStdout().find("Usage: tallow-test"), std::string::npos);
    EXPECT_EQ(outcome.exit_code, 0);
}

TEST(ToolMain, MakesARunOfTheCommonFlags) {
    const std::filesystem::path file = test_out("stats.json");
    run({"--threads", "2", "--stats", file.string()}, [](ToolRun& tool_run) {
        EXPECT_EQ(tool_run.threads, 2);
        EXPECT_EQ(allowed_threads(), 2);
        tool_run.stats.seconds["load"] = 0.5;
    });
    const nlohmann::json json = nlohmann::json::parse(read_bytes(file));
    EXPECT_EQ(json["tool"], "tallow-test");
    EXPECT_EQ(json["versions"]["threads"], "2");
    EXPECT_EQ(json["seconds"]["load"], 0.5);
    EXPECT_TRUE(json["seconds"].contains("total"));
}

TEST(ToolMain, WritesNoStatsOfAFailure) {
    const std::filesystem::path file = fresh_folder() / "stats.json";
    const Outcome outcome =
        run({"--stats", file.string()}, [](ToolRun&) { throw InputError("no"); });
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_FALSE(std::filesystem::exists(file));
}

// Without a terminal, as here: one line when a phase ends, and notes.
TEST(Progress, PrintsPlainLines) {
    const Outcome outcome = run({}, [](ToolRun& tool_run) {
        Progress& progress = tool_run.progress;
        progress.begin("irradiance", 10, "samples");
        progress.add(4);
        progress.note("note");
        progress.add(6);
        progress.end();
        progress.end();  // ends nothing
    });
    EXPECT_EQ(outcome.message.find("note\nirradiance: 10 samples in "), 0u) << outcome.message;
    EXPECT_EQ(std::ranges::count(outcome.message, '\n'), 2);
}

TEST(Progress, QuietIsSilent) {
    const Outcome outcome = run({"--quiet"}, [](ToolRun& tool_run) {
        Progress& progress = tool_run.progress;
        progress.begin("irradiance", 10, "samples");
        progress.add(10);
        progress.note("note");
        progress.end();
    });
    EXPECT_EQ(outcome.message, "");
}

}  // namespace
}  // namespace tallow
