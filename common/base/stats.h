// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "common/base/plan.h"

namespace tallow {

/// What a run measured of itself: the machine-readable summary behind --stats. A phase that did
/// not run is absent.
struct Stats {
    using Value = std::variant<double, std::int64_t, std::string>;

    std::string tool;
    std::map<std::string, double> seconds;  // phase -> wall time
    std::map<std::string, Value> counts;
    std::map<std::string, Value> errors;
    std::map<std::string, std::string> versions;
    Plan plan;
    struct FrameTime {
        int frame;
        double seconds;  // wall time, with writing
    };
    std::vector<FrameTime> frames;  // of an animation, in the order of rendering
};

/// Fills `versions` with tallow's own, the compiler's and the libraries', and the thread count.
Stats make_stats(std::string tool, int threads);

/// Adds to a count, which is 0 before.
void add_count(Stats& stats, const std::string& name, std::int64_t count);

/// Writes JSON {"tool", "seconds", "counts", "errors", "versions", "plan"}, and "frames", a list of
/// {"frame", "seconds"}, if there are any. Throws OutputError.
void write_stats(const std::filesystem::path& file, const Stats& stats);

/// Adds the time between its construction and stop() or destruction to stats.seconds[phase].
class PhaseTimer {
public:
    PhaseTimer(Stats& stats, std::string phase)
        : stats_(stats), phase_(std::move(phase)), start_(std::chrono::steady_clock::now()) {}
    ~PhaseTimer() { stop(); }
    PhaseTimer(const PhaseTimer&) = delete;
    PhaseTimer& operator=(const PhaseTimer&) = delete;

    void stop();

private:
    Stats& stats_;
    std::string phase_;
    std::chrono::steady_clock::time_point start_;
    bool stopped_ = false;
};

}  // namespace tallow
