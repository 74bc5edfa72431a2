// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace tallow {

/// Progress of one phase, told to people on stderr: on a terminal one rewritten line with
/// percentage, rate and time left; otherwise a plain line when the phase ends. Silent if quiet.
/// add() may be called from any thread.
class Progress {
public:
    explicit Progress(bool quiet);
    ~Progress();

    /// Starts a phase of `total` units ("samples", "tiles"); ends the one before.
    void begin(std::string phase, std::uint64_t total, std::string unit);
    void add(std::uint64_t done);
    /// Ends the phase and prints its line with the time that it took.
    void end();
    /// Prints a line of its own, for reports.
    void note(const std::string& line);

    /// How far the phase is, for programs that show it themselves; may be asked from any thread.
    struct State {
        std::string phase;    // empty between phases
        double fraction = 0;  // in [0, 1]
    };
    State state() const;

private:
    void draw(bool final);

    bool quiet_, terminal_;
    std::string phase_, unit_;
    std::uint64_t total_ = 0;
    std::atomic<std::uint64_t> done_{0};
    std::atomic<std::int64_t> next_draw_ns_{0};
    std::chrono::steady_clock::time_point start_;
    mutable std::mutex mutex_;
    std::atomic<bool> active_{false};
};

}  // namespace tallow
