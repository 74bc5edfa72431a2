// SPDX-License-Identifier: Apache-2.0
#include "tests/support/process.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <stdexcept>

#include "tests/support/test_files.h"

namespace tallow::test {
namespace {

void redirect(const std::filesystem::path& file, int descriptor) {
    const int target = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(target, descriptor);
    close(target);
}

}  // namespace

Result run(const std::filesystem::path& program, const std::vector<std::string>& arguments) {
    static std::atomic<int> counter{0};
    const std::filesystem::path stem = std::filesystem::path(TALLOW_TEST_OUT) /
                                       (std::to_string(getpid()) + "_" + std::to_string(counter++));
    const std::filesystem::path out = stem.string() + ".out", err = stem.string() + ".err";

    std::vector<std::string> words = {program.string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);

    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("fork failed");
    if (child == 0) {
        redirect(out, STDOUT_FILENO);
        redirect(err, STDERR_FILENO);
        execv(argv[0], argv.data());
        _exit(127);
    }
    int status = 0;
    waitpid(child, &status, 0);
    Result result{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_bytes(out),
                  read_bytes(err)};
    std::filesystem::remove(out);
    std::filesystem::remove(err);
    return result;
}

Result precompute(const std::vector<std::string>& arguments) {
    return run(TALLOW_PRECOMPUTE, arguments);
}

Result render(const std::vector<std::string>& arguments) { return run(TALLOW_RENDER, arguments); }

}  // namespace tallow::test
