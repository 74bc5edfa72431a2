// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace tallow {

/// How much more memory this process can have, and what sets that limit, in words.
struct AvailableMemory {
    double bytes;
    std::string limit;  // "free memory", "control group's limit", "address space limit (ulimit -v)"
};

/// The least of: what the kernel says is available (MemAvailable: free, or in caches that it would
/// give up), what the control groups of this process (version 1 and 2) leave, and RLIMIT_AS.
/// Infinite where none can be read. `root` stands for "/", for tests.
AvailableMemory available_memory(const std::filesystem::path& root = "/");

}  // namespace tallow
