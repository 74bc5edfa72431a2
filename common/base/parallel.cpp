// SPDX-License-Identifier: Apache-2.0
// Index loops over TBB, with Ctrl-C turned into an exception that unwinds like any other error.
#include "common/base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <utility>

#include "common/base/errors.h"

#ifdef TALLOW_SANITIZE_THREAD
#include <sanitizer/tsan_interface.h>
#endif

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

/// Tells the thread sanitizer, which cannot see into TBB, what a loop promises: what came before it
/// is done before each range, and each range before what comes after it. Of the order of ranges it
/// says nothing, so that races between them are found.
class LoopOrder {
public:
    class Range {
    public:
        explicit Range(LoopOrder& loop) : loop_(loop) { acquire(&loop_.begin_); }
        ~Range() { release(&loop_.end_); }

    private:
        LoopOrder& loop_;
    };

    LoopOrder() { release(&begin_); }
    ~LoopOrder() { acquire(&end_); }

private:
#ifdef TALLOW_SANITIZE_THREAD
    static void acquire(char* place) { __tsan_acquire(place); }
    static void release(char* place) { __tsan_release(place); }
#else
    static void acquire(char*) {}
    static void release(char*) {}
#endif

    char begin_ = 0, end_ = 0;  // only their addresses matter
};

/// Where this thread's loops run: the arena of the innermost ThreadLimit that it has made, or, if
/// null, the one it is in.
thread_local tbb::task_arena* t_arena = nullptr;

/// Threads that TBB allows the process: the smallest of all limits alive.
int process_limit() {
    return int(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace

void parallel_ranges(std::size_t n, std::size_t grain,
                     const std::function<void(std::size_t, std::size_t)>& body) {
    if (interrupted()) throw Interrupted();
    LoopOrder order;
    const auto loop = [&] {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain),
                          [&](const tbb::blocked_range<std::size_t>& range) {
                              if (interrupted()) throw Interrupted();
                              const LoopOrder::Range in_order(order);
                              body(range.begin(), range.end());
                          });
    };
    if (t_arena != nullptr)
        t_arena->execute(loop);
    else
        loop();
}

struct ThreadLimit::Impl {
    // Made in place: a global_control can be copied, but the copy controls nothing.
    explicit Impl(int threads)
        : control(tbb::global_control::max_allowed_parallelism, std::size_t(threads)),
          arena(process_limit()),
          outer(std::exchange(t_arena, &arena)) {}
    ~Impl() { t_arena = outer; }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    tbb::global_control control;  // binds the whole process, Embree's loops too
    tbb::task_arena arena;        // has as many places, where the control only takes some away
    tbb::task_arena* outer;
};

ThreadLimit::ThreadLimit(int threads)
    : threads_(threads > 0 ? threads : tbb::info::default_concurrency()),
      impl_(std::make_unique<Impl>(threads_)) {}

ThreadLimit::~ThreadLimit() = default;

int allowed_threads() {
    const int places =
        t_arena != nullptr ? t_arena->max_concurrency() : tbb::this_task_arena::max_concurrency();
    return std::min(process_limit(), places);
}

void install_interrupt_handler() {
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
}

void interrupt() { g_interrupted = true; }

bool interrupted() { return g_interrupted.load(std::memory_order_relaxed); }

}  // namespace tallow
