// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace tallow {

/// Calls body(begin, end) for disjoint ranges that cover [0, n), on all threads. Exceptions of the
/// body reach the caller. Every index must write its own slot, so that results do not depend on
/// the number of threads or on the order of execution. Throws Interrupted after Ctrl-C.
void parallel_ranges(std::size_t n, std::size_t grain,
                     const std::function<void(std::size_t begin, std::size_t end)>& body);

/// Calls body(i) for each i in [0, n), on all threads.
template <class Body>
void parallel_for(std::size_t n, std::size_t grain, Body&& body) {
    parallel_ranges(n, grain, [&body](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
}

/// While it lives, loops of the thread that made it run on `threads` threads, even where the
/// machine has fewer cores; 0 means one for each core. No loop of the process gets more, so that of
/// nested limits the smallest holds. To be destroyed in reverse order, as local variables are.
class ThreadLimit {
public:
    explicit ThreadLimit(int threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;
    int threads() const { return threads_; }

private:
    struct Impl;
    int threads_;
    std::unique_ptr<Impl> impl_;
};

/// Threads that a loop of this thread may use now.
int allowed_threads();

/// From now on Ctrl-C (SIGINT, SIGTERM) makes parallel loops throw Interrupted; a second Ctrl-C
/// ends the process at once.
void install_interrupt_handler();
bool interrupted();

/// The same by the program's own wish: loops of all threads stop, for good.
void interrupt();

}  // namespace tallow
