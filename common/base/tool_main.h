// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "common/base/cli.h"
#include "common/base/progress.h"
#include "common/base/stats.h"

namespace tallow {

/// What the flags that every tool has make of a run.
struct ToolRun {
    int threads;  ///< that loops run on
    Progress progress;
    Stats stats;  ///< written after the body, if --stats asks for it, with its time as "total"
};

/// Runs a program: parses the flags that `declare` adds, runs `body`, and turns exceptions into
/// one line on stderr and an exit code. The only place that knows exit codes:
///
///     0 ok   2 UsageError   3 InputError   4 OutputError   130 Interrupted   1 anything else
///
/// The first line on stderr of a failure is "tool: error: <message>" (exit 3, 4),
/// "tool: usage: <message>" (2) or "tool: internal error: <message>" (1).
int tool_main(const std::string& tool, const std::string& description, int argc, char** argv,
              const std::function<void(CommandLine&)>& declare,
              const std::function<void(ToolRun&)>& body);

}  // namespace tallow
