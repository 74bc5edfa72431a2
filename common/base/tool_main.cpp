// SPDX-License-Identifier: Apache-2.0
#include "common/base/tool_main.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "common/base/errors.h"
#include "common/base/output_file.h"
#include "common/base/parallel.h"

namespace tallow {
namespace {

int report(const std::string& tool, const char* kind, const std::exception& error, int exit_code) {
    std::fputs(fmt::format("{}: {}: {}\n", tool, kind, error.what()).c_str(), stderr);
    return exit_code;
}

/// A result that did not reach its reader must not count as success.
void flush_stdout() {
    if (std::fflush(stdout) != 0 || std::ferror(stdout))
        throw OutputError(fmt::format("stdout: cannot be written: {}", std::strerror(errno)));
}

void run(const std::string& tool, const CommonOptions& common,
         const std::function<void(ToolRun&)>& body) {
    if (common.stats) require_writable(*common.stats);
    const ThreadLimit limit(common.threads);
    ToolRun tool_run{limit.threads(), Progress(common.quiet), make_stats(tool, limit.threads())};
    PhaseTimer total(tool_run.stats, "total");
    body(tool_run);
    total.stop();
    if (common.stats) write_stats(*common.stats, tool_run.stats);
}

}  // namespace

int tool_main(const std::string& tool, const std::string& description, int argc, char** argv,
              const std::function<void(CommandLine&)>& declare,
              const std::function<void(ToolRun&)>& body) {
    try {
        CommonOptions common;
        CommandLine line(tool, description);
        declare(line);
        line.add_common(common);
        if (line.parse(argc, argv)) {
            install_interrupt_handler();
            run(tool, common, body);
        }
        flush_stdout();
        return 0;
    } catch (const UsageError& error) {
        return report(tool, "usage", error, 2);
    } catch (const InputError& error) {
        return report(tool, "error", error, 3);
    } catch (const OutputError& error) {
        return report(tool, "error", error, 4);
    } catch (const Interrupted& error) {
        return report(tool, "error", error, 130);
    } catch (const std::exception& error) {
        return report(tool, "internal error", error, 1);
    }
}

}  // namespace tallow
