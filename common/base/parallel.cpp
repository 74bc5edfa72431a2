// SPDX-License-Identifier: Apache-2.0
// Index loops over TBB, with Ctrl-C turned into an exception that unwinds like any other error.
#include "common/base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <csignal>

#include "common/base/errors.h"

namespace tallow {
namespace {

std::atomic<bool> g_interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "the signal handler writes it");

extern "C" void on_signal(int signal) {
    if (g_interrupted.exchange(true)) {
        std::signal(signal, SIG_DFL);
        std::raise(signal);
    }
}

}  // namespace

void parallel_ranges(std::size_t n, std::size_t grain,
                     const std::function<void(std::size_t, std::size_t)>& body) {
    if (interrupted()) throw Interrupted();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          if (interrupted()) throw Interrupted();
                          body(range.begin(), range.end());
                      });
}

struct ThreadLimit::Impl {
    tbb::global_control control;
};

ThreadLimit::ThreadLimit(int threads)
    : threads_(threads > 0 ? threads : tbb::info::default_concurrency()) {
    impl_ = std::make_unique<Impl>(Impl{tbb::global_control(
        tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads_))});
}

ThreadLimit::~ThreadLimit() = default;

int allowed_threads() {
    return int(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void install_interrupt_handler() {
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
}

bool interrupted() { return g_interrupted.load(std::memory_order_relaxed); }

}  // namespace tallow
