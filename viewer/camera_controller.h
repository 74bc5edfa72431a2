// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <set>

#include "common/scene/camera.h"
#include "viewer/input.h"

namespace tallow {

/// Moves a camera as keys and the mouse say: W A S D along the view and sideways, Q E down and up,
/// the right button turns, the left one orbits around the point under it, the wheel changes the
/// speed and Shift makes it faster. Knows time only as it is told, so that scripts repeat.
///
/// The camera's `up` stays; its look_at is carried along at the same distance. Until something is
/// pressed the camera is to the bit what it was.
class CameraController {
public:
    /// Where the scene is met under a pixel of the camera's image, if it is.
    using PointUnder = std::function<std::optional<Vec3>(const Camera& camera, Vec2 pixel)>;

    /// It starts with `camera`, standing still in frame 0 or as camera_at() made it.
    explicit CameraController(Camera camera);

    void handle(const InputEvent& event, const PointUnder& point_under);
    /// Goes on for some time, with the keys that are held.
    void advance(double seconds);

    const Camera& camera() const { return camera_; }
    /// Changes whenever the camera does.
    int revision() const { return revision_; }
    float speed() const { return speed_; }  // mm/s, without Shift
    /// Whether a key or button is held that moves the camera.
    bool is_moving() const;

private:
    void press(const KeyEvent& event);
    void click(const ButtonEvent& event, const PointUnder& point_under);
    void drag(Vec2 to);
    void turn_about(Vec3 pivot, Vec2 pixels);
    void changed() { ++revision_; }

    Camera camera_;
    float speed_;
    std::set<Key> held_;
    std::optional<Button> button_;
    Vec3 pivot_{0};
    Vec2 cursor_{0};
    int revision_ = 0;
};

}  // namespace tallow
