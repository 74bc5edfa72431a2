// SPDX-License-Identifier: Apache-2.0
#include "common/base/available_memory.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>

#include "tests/support/test_files.h"

namespace tallow {
namespace {

/// A machine's files under a folder of its own.
class Machine {
public:
    Machine() : root_(fresh_folder("available_memory")) {
        put("proc/meminfo",
            "MemTotal: 8000000 kB\nMemFree: 1000000 kB\nMemAvailable: 4000000 kB\n");
        put("proc/self/cgroup", "0::/\n");
    }
    void put(const std::string& file, const std::string& text) const {
        std::filesystem::create_directories((root_ / file).parent_path());
        write_bytes(root_ / file, text);
    }
    AvailableMemory memory() const { return available_memory(root_); }

private:
    std::filesystem::path root_;
};

TEST(AvailableMemory, IsWhatTheKernelSaysIsAvailable) {
    const Machine machine;
    EXPECT_EQ(machine.memory().bytes, 4096e6);
    EXPECT_EQ(machine.memory().limit, "free memory");
}

TEST(AvailableMemory, ObeysControlGroupsOfVersion2) {
    const Machine machine;
    machine.put("proc/self/cgroup", "0::/user/job\n");
    machine.put("sys/fs/cgroup/user/memory.max", "2000000000\n");  // the group around it
    machine.put("sys/fs/cgroup/user/memory.current", "700000000\n");
    machine.put("sys/fs/cgroup/user/memory.stat", "anon 1\ninactive_file 200000000\n");
    machine.put("sys/fs/cgroup/user/job/memory.max", "max\n");
    machine.put("sys/fs/cgroup/user/job/memory.current", "100\n");
    EXPECT_EQ(machine.memory().bytes, 1.5e9);
    EXPECT_EQ(machine.memory().limit, "control group's limit");
}

TEST(AvailableMemory, ObeysControlGroupsOfVersion1) {
    const Machine machine;
    machine.put("proc/self/cgroup", "5:cpu,cpuacct:/\n4:memory:/docker/4711\n0::/\n");
    // In a container the path is the host's; its own group is the top folder.
    machine.put("sys/fs/cgroup/memory/memory.limit_in_bytes", "1000000000\n");
    machine.put("sys/fs/cgroup/memory/memory.usage_in_bytes", "400000000\n");
    machine.put("sys/fs/cgroup/memory/memory.stat", "total_inactive_file 100000000\n");
    EXPECT_EQ(machine.memory().bytes, 7e8);
}

TEST(AvailableMemory, ObeysTheAddressSpaceLimit) {
    const Machine machine;
    machine.put("proc/self/status", "VmSize:\t 1000 kB\n");
    machine.put("proc/meminfo", "MemAvailable: 1000000000000 kB\n");
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
    // More than sanitizers reserve, 20 TiB: below that they cannot allocate.
    const rlimit tight{std::min(before.rlim_cur, rlim_t(1) << 46), before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);  // lowering is always allowed
    const AvailableMemory memory = machine.memory();
    setrlimit(RLIMIT_AS, &before);
    EXPECT_EQ(memory.bytes, double(tight.rlim_cur) - 1024e3);
    EXPECT_EQ(memory.limit, "address space limit (ulimit -v)");
}

TEST(AvailableMemory, IsUnlimitedWhereNothingIsKnown) {
    const AvailableMemory memory = available_memory(fresh_folder("no_machine"));
    EXPECT_GT(memory.bytes, 1e30);
}

}  // namespace
}  // namespace tallow
