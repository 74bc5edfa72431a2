// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <mutex>
#include <set>
#include <thread>

#include "common/base/parallel.h"

namespace tallow {

/// Threads that take part in a parallel loop: waits for `expected` of them to come, however busy
/// the machine is, and then a moment for one too many.
inline std::size_t threads_in_a_loop(std::size_t expected) {
    using namespace std::chrono_literals;
    using Clock = std::chrono::steady_clock;
    std::mutex mutex;
    std::set<std::thread::id> seen;
    const auto enter = [&] {
        const std::lock_guard lock(mutex);
        seen.insert(std::this_thread::get_id());
        return seen.size();
    };
    parallel_for(16, 1, [&](std::size_t) {
        const auto start = Clock::now();
        while (enter() < expected && Clock::now() - start < 20s) std::this_thread::sleep_for(1ms);
        std::this_thread::sleep_for(4ms);
    });
    return seen.size();
}

}  // namespace tallow
