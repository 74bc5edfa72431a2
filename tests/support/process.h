// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

// Running our programs as a user would.
namespace tallow::test {

struct Result {
    int exit_code;
    std::string out, err;  // stdout, stderr

    std::string first_error_line() const { return err.substr(0, err.find('\n')); }
};

/// Runs a program without a shell and waits for it. `arguments` exclude the program's name.
Result run(const std::filesystem::path& program, const std::vector<std::string>& arguments);

/// tallow-precompute and tallow-render of this build.
Result precompute(const std::vector<std::string>& arguments);
Result render(const std::vector<std::string>& arguments);

}  // namespace tallow::test
