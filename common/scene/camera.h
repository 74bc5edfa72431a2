// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/base/vec.h"

namespace tallow {

/// Turns a camera about the axis through the point that it looks at: in frame k by k / frames of
/// `angle`, so that a full circle does not repeat its first frame.
struct Turntable {
    int frames;
    Vec3 axis;    // unit
    float angle;  // radians, right-handed about the axis
};

/// Where a camera is in one frame.
struct Keyframe {
    int frame;
    Vec3 position, look_at;
    float fov;
};

/// How a camera changes from frame to frame: not at all, on a turntable, or from keyframe to
/// keyframe (frames strictly increasing, at least one).
using CameraMotion = std::variant<std::monostate, Turntable, std::vector<Keyframe>>;

/// A perspective camera with a pinhole or a thin lens. Lengths in mm, `fov` is the vertical field
/// of view in radians.
struct Camera {
    std::string name;
    Vec3 position;
    Vec3 look_at;
    Vec3 up;
    float fov;
    int width, height;                  // pixels
    float lens_radius = 0;              // 0 is a pinhole
    float focus = 0;                    // distance along the view of the plane that is sharp
    std::optional<Vec3> focus_point{};  // in that plane, whatever the frame; else `focus` stays
    CameraMotion motion{};              // what is above is how it stands in frame 0
    int frame = 0;                      // of a moving camera that it was taken from
};

/// Ray through the image at (x, y) in pixels; (0, 0) is the top left corner of the image, y runs
/// down. Unit direction. `lens`, uniform in [0, 1)^2, says where on the lens the ray starts: (0.5,
/// 0.5) is its centre. Without a lens it does not matter.
Ray camera_ray(const Camera& camera, float x, float y, Vec2 lens = Vec2(0.5f));

/// The same for many rays of a camera, which must stand still meanwhile.
class CameraRays {
public:
    explicit CameraRays(const Camera& camera);
    Ray operator()(float x, float y, Vec2 lens = Vec2(0.5f)) const;

private:
    const Camera& camera_;
    Vec3 forward_, right_, up_;
    float pixel_size_;  // at distance 1
};

/// Frames that a camera has, from 0: those of the turntable, or up to the last keyframe; 1 if it
/// stands still.
int frame_count(const Camera& camera);

/// A camera as it stands still in one frame.
///
/// Keyframes are followed along cubic Hermite splines: of position and of look_at, and of the
/// logarithm of tan(fov / 2), so that zooms are even and stay possible. Their tangents are those of
/// the parabola through three keyframes (Catmull-Rom for uneven frames), no longer than three times
/// the slower of the two neighbouring mean speeds, so that a camera that rests between two equal
/// keyframes does not drift; at the ends they follow the chord. Before the first keyframe the
/// camera waits.
///
/// Domain   frame in [0, frame_count()).
/// Source   Catmull, Rom 1974 for the tangents; the limit is that of de Boor, Swartz 1977, on
///          lengths instead of signed slopes.
Camera camera_at(const Camera& camera, int frame);

}  // namespace tallow
