// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "viewer/camera_controller.h"
#include "viewer/frame_log.h"
#include "viewer/view_options.h"
#include "viewer/view_state.h"

namespace tallow {

/// A user's session, whether at a window or as a script says: what events make of camera and state,
/// and what becomes of the frames that are shown.
class Session {
public:
    /// Both must outlive it. Throws UsageError, OutputError.
    Session(const Scene& scene, const ViewOptions& options);

    void handle(const InputEvent& event, const CameraController::PointUnder& point_under);
    void advance(double seconds) { controller_.advance(seconds); }

    const Camera& camera() const { return controller_.camera(); }
    const ViewState& state() const { return state_; }
    bool is_moving() const { return controller_.is_moving(); }
    int samples() const { return samples_; }

    /// Whether camera or scene are others than at the last call; true at the first.
    bool take_change();

    /// The frame is on the screen. Throws OutputError.
    void log(const ViewFrame& frame, double latency_ms);
    /// Saves the frame, if F12 was pressed since and the frame is what is wished for at the full
    /// resolution; else the wish waits. Returns the name without extension. Throws OutputError.
    std::optional<std::filesystem::path> save_wished(const ViewFrame& frame,
                                                     const std::string& cache_name);
    decltype(Image::metadata) metadata(const std::string& cache_name) const;

private:
    bool shows_wish(const ViewFrame& frame) const;

    const Scene& scene_;
    const ViewOptions& options_;
    CameraController controller_;
    ViewState state_;
    int samples_;
    std::optional<FrameLog> log_;
    bool screenshot_ = false;
    int seen_revision_ = -1;
    std::optional<SceneWish> seen_wish_;
};

}  // namespace tallow
