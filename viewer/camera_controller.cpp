// SPDX-License-Identifier: Apache-2.0
// Keys and mouse -> camera.
#include "viewer/camera_controller.h"

#include <algorithm>
#include <cmath>

#include "common/base/overloaded.h"

namespace tallow {
namespace {

// Chosen: half of the distance to what is looked at in a second, four times that with Shift.
constexpr float kSpeedPerDistance = 0.5f;
constexpr float kFaster = 4;
constexpr float kSpeedPerClick = 1.25f;
constexpr float kLeastSpeed = 1e-6f, kMostSpeed = 1e9f;  // mm/s

// Chosen: half a turn for 630 pixels.
constexpr float kTurnPerPixel = 0.005f;  // radians

// The view may not come nearer to `up` than this, where left and right lose their meaning.
constexpr float kNearestToUp = 0.05f;  // radians

/// Source: Rodrigues' formula. `axis` is unit.
Vec3 rotate(Vec3 v, Vec3 axis, float angle) {
    const float c = std::cos(angle), s = std::sin(angle);
    return c * v + s * glm::cross(axis, v) + (1 - c) * glm::dot(axis, v) * axis;
}

Vec3 forward_of(const Camera& camera) { return glm::normalize(camera.look_at - camera.position); }

constexpr Key kMoving[] = {Key::w, Key::a, Key::s, Key::d, Key::q, Key::e};

}  // namespace

CameraController::CameraController(Camera camera)
    : camera_(std::move(camera)),
      speed_(kSpeedPerDistance * glm::distance(camera_.position, camera_.look_at)) {
    camera_.motion = {};
}

void CameraController::handle(const InputEvent& event, const PointUnder& point_under) {
    std::visit(Overloaded{
                   [&](const KeyEvent& key) { press(key); },
                   [&](const ButtonEvent& button) { click(button, point_under); },
                   [&](const MotionEvent& motion) { drag(motion.at); },
                   [&](const WheelEvent& wheel) {
                       speed_ = std::clamp(speed_ * std::pow(kSpeedPerClick, wheel.clicks),
                                           kLeastSpeed, kMostSpeed);
                   },
                   [&](const ResizeEvent& size) {
                       if (size.width == camera_.width && size.height == camera_.height) return;
                       camera_.width = size.width, camera_.height = size.height;
                       changed();
                   },
                   [](const CloseEvent&) {},
               },
               event);
}

void CameraController::press(const KeyEvent& event) {
    if (event.down)
        held_.insert(event.key);
    else
        held_.erase(event.key);
}

void CameraController::click(const ButtonEvent& event, const PointUnder& point_under) {
    cursor_ = event.at;
    if (!event.down) {
        if (button_ == event.button) button_.reset();
        return;
    }
    button_ = event.button;
    if (event.button == Button::left)
        pivot_ = point_under(camera_, event.at).value_or(camera_.look_at);
}

void CameraController::drag(Vec2 to) {
    const Vec2 by = to - cursor_;
    cursor_ = to;
    if (!button_ || by == Vec2(0)) return;
    turn_about(*button_ == Button::left ? pivot_ : camera_.position, by);
}

// The whole camera is turned, so that the pivot keeps its place in the picture.
void CameraController::turn_about(Vec3 pivot, Vec2 pixels) {
    const Vec3 up = glm::normalize(camera_.up), forward = forward_of(camera_);
    const float elevation = std::asin(std::clamp(glm::dot(forward, up), -1.0f, 1.0f));
    const float most = kPi / 2 - kNearestToUp;
    const float wanted = elevation - kTurnPerPixel * pixels.y;
    // A camera that a scene has put nearer to `up` than that may stay there, but not go on.
    const float pitch =
        std::clamp(wanted, std::min(-most, elevation), std::max(most, elevation)) - elevation;
    const Vec3 right = glm::normalize(glm::cross(forward, up));
    const auto turned = [&](Vec3 v) {
        return rotate(rotate(v, right, pitch), up, -kTurnPerPixel * pixels.x);
    };
    const float distance = glm::distance(camera_.position, camera_.look_at);
    camera_.position = pivot + turned(camera_.position - pivot);
    camera_.look_at = camera_.position + distance * glm::normalize(turned(forward));
    changed();
}

bool CameraController::is_moving() const {
    return button_.has_value() ||
           std::ranges::any_of(kMoving, [&](Key key) { return held_.contains(key); });
}

void CameraController::advance(double seconds) {
    const auto axis = [&](Key plus, Key minus) {
        return float(held_.contains(plus)) - float(held_.contains(minus));
    };
    const Vec3 forward = forward_of(camera_), up = glm::normalize(camera_.up);
    const Vec3 right = glm::normalize(glm::cross(forward, up));
    const Vec3 way =
        axis(Key::w, Key::s) * forward + axis(Key::d, Key::a) * right + axis(Key::e, Key::q) * up;
    if (way == Vec3(0)) return;
    const Vec3 step = float(seconds) * speed_ * (held_.contains(Key::shift) ? kFaster : 1.0f) * way;
    camera_.position += step;
    camera_.look_at += step;
    changed();
}

}  // namespace tallow
