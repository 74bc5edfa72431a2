// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace tallow {

/// Path of a file that the running test may write: each test has a folder of its own, because
/// tests run at the same time.
inline std::filesystem::path test_out(const std::string& name) {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    const auto folder = std::filesystem::path(TALLOW_TEST_OUT) /
                        (std::string(test->test_suite_name()) + "." + test->name());
    std::filesystem::create_directories(folder);
    return folder / name;
}

/// The running test's folder, emptied. `part` tells apart several of one test.
inline std::filesystem::path fresh_folder(const std::string& part = "files") {
    const std::filesystem::path folder = test_out(part);
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
}

inline std::string read_bytes(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

inline void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
    // Not rewritten in place: ext4 would flush each file to the disk, 3 ms a time.
    std::filesystem::remove(file);
    std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace tallow
