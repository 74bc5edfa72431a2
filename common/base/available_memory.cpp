// SPDX-License-Identifier: Apache-2.0
// What /proc, /sys/fs/cgroup and the resource limits say about memory.
// Source: Linux kernel documentation, admin-guide/cgroup-v1/memory, admin-guide/cgroup-v2,
// filesystems/proc.
#include "common/base/available_memory.h"

#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>

namespace tallow {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// The number after `key` in a file of lines "key number ...".
std::optional<double> number_after(const std::filesystem::path& file, const std::string& key) {
    std::ifstream stream(file);
    for (std::string word; stream >> word;)
        if (double number = 0; word == key && stream >> number) return number;
    return std::nullopt;
}

/// A file that holds nothing but a number; "max" and the like are no number.
std::optional<double> number_in(const std::filesystem::path& file) {
    std::ifstream stream(file);
    if (double number = 0; stream >> number) return number;
    return std::nullopt;
}

struct GroupFiles {
    const char *limit, *usage, *cache;  // the last a key of memory.stat
};

/// What the group in `folder` and the groups around it, up to `top`, leave. Pages of files are
/// counted as used, but given up when memory gets short.
double left_in_groups(std::filesystem::path folder, const std::filesystem::path& top,
                      const GroupFiles& names) {
    double least = kUnlimited;
    for (;; folder = folder.parent_path()) {
        const auto limit = number_in(folder / names.limit), usage = number_in(folder / names.usage);
        if (limit && usage) {
            const double cache = number_after(folder / "memory.stat", names.cache).value_or(0);
            least = std::min(least, std::max(0.0, *limit - std::max(0.0, *usage - cache)));
        }
        if (folder == top || !folder.has_relative_path()) return least;
    }
}

/// Reads /proc/self/cgroup, lines "number:controllers:/path"; inside a container the path may be
/// one that only the host can see: then the top folder is the container's own group.
double left_in_control_groups(const std::filesystem::path& root) {
    std::ifstream stream(root / "proc/self/cgroup");
    double least = kUnlimited;
    for (std::string line; std::getline(stream, line);) {
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) continue;
        const std::string controllers = line.substr(first + 1, second - first - 1);
        const bool v2 = controllers.empty();
        if (!v2 && ("," + controllers + ",").find(",memory,") == std::string::npos) continue;
        const std::filesystem::path top = root / (v2 ? "sys/fs/cgroup" : "sys/fs/cgroup/memory");
        const std::filesystem::path path = std::filesystem::path(line.substr(second + 1));
        std::filesystem::path folder = top / path.relative_path();
        if (std::error_code error; !std::filesystem::exists(folder, error)) folder = top;
        least = std::min(
            least,
            v2 ? left_in_groups(folder, top, {"memory.max", "memory.current", "inactive_file"})
               : left_in_groups(
                     folder, top,
                     {"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"}));
    }
    return least;
}

double left_of_address_space(const std::filesystem::path& root) {
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnlimited;
    const double used = number_after(root / "proc/self/status", "VmSize:").value_or(0) * 1024;
    return std::max(0.0, double(limit.rlim_cur) - used);
}

}  // namespace

AvailableMemory available_memory(const std::filesystem::path& root) {
    AvailableMemory least{kUnlimited, "free memory"};
    if (const auto kib = number_after(root / "proc/meminfo", "MemAvailable:"))
        least.bytes = *kib * 1024;
    if (const double left = left_in_control_groups(root); left < least.bytes)
        least = {left, "control group's limit"};
    if (const double left = left_of_address_space(root); left < least.bytes)
        least = {left, "address space limit (ulimit -v)"};
    return least;
}

}  // namespace tallow
