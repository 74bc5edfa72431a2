// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>

#include "viewer/view_frame.h"
#include "viewer/view_state.h"

namespace tallow {

/// One line (CSV) for each frame that was shown, written at once:
///
///     frame            from 0
///     time_s           since the start
///     kind             draft or pass
///     milliseconds     that it took to compute
///     latency_ms       from the event that asked for it to the screen
///     width, height    of the picture; scale: pixels of the window that its pixels are wide
///     samples          camera rays a pixel so far
///     shading_points   on bodies, in this draft or pass
///     tolerance, largest_bound (if certified), rss_mb: resident memory
///     aov, x_mm, y_mm, z_mm: what is shown, from where
///     primary_ms, exitance_ms, single_ms, surface_ms, indirect_ms: where the time went
class FrameLog {
public:
    /// Throws OutputError.
    explicit FrameLog(const std::filesystem::path& file);
    void add(const ViewFrame& frame, Aov aov, double latency_ms);

private:
    std::filesystem::path file_;
    std::ofstream stream_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    int next_ = 0;
};

/// Resident memory of this process, bytes; 0 where the system does not tell.
std::uint64_t resident_memory();

}  // namespace tallow
