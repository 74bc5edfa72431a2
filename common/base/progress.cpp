// SPDX-License-Identifier: Apache-2.0
#include "common/base/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace tallow {
namespace {

constexpr auto kRedrawInterval = std::chrono::milliseconds(100);

// Erases what the terminal shows right of the cursor (ECMA-48 "erase in line").
constexpr const char* kEraseLine = "\r\033[K";

/// "12.3k", "4.56M": three digits are as many as a person reads while they change.
std::string short_number(double x) {
    if (x >= 1e9) return fmt::format("{:.3g}G", x / 1e9);
    if (x >= 1e6) return fmt::format("{:.3g}M", x / 1e6);
    if (x >= 1e3) return fmt::format("{:.3g}k", x / 1e3);
    return fmt::format("{:.3g}", x);
}

/// A closed stderr is no reason to fail: unlike fmt::print(), this does not throw.
template <class... Args>
void print_to_people(fmt::format_string<Args...> format, Args&&... args) {
    std::fputs(fmt::format(format, std::forward<Args>(args)...).c_str(), stderr);
}

}  // namespace

Progress::Progress(bool quiet) : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) != 0) {}

// An unfinished phase was interrupted or failed: its line is only wiped, not reported as done.
Progress::~Progress() {
    if (active_ && terminal_ && !quiet_) print_to_people("{}", kEraseLine);
}

void Progress::begin(std::string phase, std::uint64_t total, std::string unit) {
    end();
    const std::lock_guard lock(mutex_);
    phase_ = std::move(phase);
    unit_ = std::move(unit);
    total_ = total;
    done_ = 0;
    start_ = std::chrono::steady_clock::now();
    next_draw_ns_ = std::chrono::nanoseconds(kRedrawInterval).count();
    active_ = true;
}

void Progress::add(std::uint64_t done) {
    done_.fetch_add(done, std::memory_order_relaxed);
    if (quiet_ || !terminal_) return;
    const std::chrono::nanoseconds elapsed = std::chrono::steady_clock::now() - start_;
    std::int64_t due = next_draw_ns_.load(std::memory_order_relaxed);
    if (elapsed.count() < due) return;
    const std::int64_t next = (elapsed + kRedrawInterval).count();
    if (next_draw_ns_.compare_exchange_strong(due, next)) draw(false);  // one thread draws
}

void Progress::end() {
    if (!active_) return;
    draw(true);
    active_ = false;
}

void Progress::note(const std::string& line) {
    if (quiet_) return;
    const std::lock_guard lock(mutex_);
    print_to_people("{}{}\n", terminal_ ? kEraseLine : "", line);
}

Progress::State Progress::state() const {
    const std::lock_guard lock(mutex_);
    if (!active_) return {};
    return {phase_, total_ > 0 ? std::min(1.0, double(done_) / double(total_)) : 1.0};
}

void Progress::draw(bool final) {
    if (quiet_) return;
    const std::lock_guard lock(mutex_);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    const double seconds = elapsed.count();
    const auto done = static_cast<double>(done_.load(std::memory_order_relaxed));
    const char* start_of_line = terminal_ ? kEraseLine : "";
    if (final) {
        print_to_people("{}{}: {} {} in {:.3g} s\n", start_of_line, phase_, done_.load(), unit_,
                        seconds);
        return;
    }
    const double fraction = total_ > 0 ? done / static_cast<double>(total_) : 1;
    const double rate = done / seconds;
    const double left = fraction > 0 ? seconds * (1 - fraction) / fraction : 0;
    print_to_people("{}{}: {:3.0f} %, {} {}/s, {:.0f} s left", start_of_line, phase_,
                    100 * fraction, short_number(rate), unit_, left);
}

}  // namespace tallow
