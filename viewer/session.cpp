// SPDX-License-Identifier: Apache-2.0
#include "viewer/session.h"

#include "viewer/screenshot.h"

namespace tallow {

Session::Session(const Scene& scene, const ViewOptions& options)
    : scene_(scene),
      options_(options),
      controller_(first_camera(options, scene)),
      state_(scene, float(options.tolerance.value_or(double(scene.settings.tolerance)))),
      samples_(options.samples.value_or(scene.settings.samples)) {
    if (options.log) log_.emplace(*options.log);
}

void Session::handle(const InputEvent& event, const CameraController::PointUnder& point_under) {
    controller_.handle(event, point_under);
    state_.handle(event);
    screenshot_ |= state_.take_screenshot_wish();
}

bool Session::take_change() {
    if (seen_revision_ == controller_.revision() && seen_wish_ == state_.wish()) return false;
    seen_revision_ = controller_.revision();
    seen_wish_ = state_.wish();
    return true;
}

void Session::log(const ViewFrame& frame, double latency_ms) {
    if (log_) log_->add(frame, state_.aov(), latency_ms);
}

bool Session::shows_wish(const ViewFrame& frame) const {
    const Camera& a = frame.camera;
    const Camera& b = camera();
    return a.position == b.position && a.look_at == b.look_at && a.width == b.width &&
           a.height == b.height && frame.wish == state_.wish();
}

std::optional<std::filesystem::path> Session::save_wished(const ViewFrame& frame,
                                                          const std::string& cache_name) {
    if (!screenshot_ || !shows_wish(frame)) return std::nullopt;
    screenshot_ = false;
    return save_screenshot(options_.screenshots.value_or("."), scene_, frame, state_,
                           metadata(cache_name));
}

decltype(Image::metadata) Session::metadata(const std::string& cache_name) const {
    return {{"tallow/scene", scene_.file.string()},
            {"tallow/camera", camera().name},
            {"tallow/cache", cache_name},
            {"tallow/version", TALLOW_VERSION}};
}

}  // namespace tallow
