// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>
#include <stop_token>

#include "render/band_renderer.h"
#include "viewer/view_frame.h"

namespace tallow {

/// A picture that gets better while nothing moves: pass by pass it takes the camera rays that
/// render_image() takes at once, with the same random numbers, so that after `samples` of them it
/// is its picture within the tolerance of the sums.
class ProgressiveImage {
public:
    /// `world` must outlive it, and may not change meanwhile.
    ProgressiveImage(const PreparedScene& world, Camera camera, int samples, std::stop_token stop);
    ProgressiveImage(const ProgressiveImage&) = delete;
    ProgressiveImage& operator=(const ProgressiveImage&) = delete;

    /// Adds a camera ray to each pixel. Returns false if it was stopped: then it is of no use any
    /// more.
    bool add_pass();
    bool finished() const { return done_ == view_.samples; }
    /// What there is after at least one pass.
    ViewFrame frame() const;

private:
    Camera camera_;
    View view_;
    Stats stats_;
    RenderCounts counts_;
    std::deque<BandRenderer> bands_;
    int done_ = 0;
    std::int64_t points_of_pass_ = 0;
    double milliseconds_ = 0;  // of the last pass
};

/// A draft of one ray a pixel, with pixels `scale` times as wide as the camera's. Nothing if it was
/// stopped.
std::optional<ViewFrame> draw_draft(const PreparedScene& world, const Camera& camera, float scale,
                                    std::stop_token stop);

}  // namespace tallow
