// SPDX-License-Identifier: Apache-2.0
// A moving camera and a frame -> a camera that stands still. In double: keyframes may be far apart.
#include <algorithm>
#include <cmath>
#include <span>

#include "common/base/overloaded.h"
#include "common/scene/camera.h"

namespace tallow {
namespace {

constexpr double kLargestTangent = 3;  // in speeds of a neighbouring segment; see camera_at()

// Rodrigues' formula.
DVec3 rotate(DVec3 v, DVec3 axis, double angle) {
    const double cosine = std::cos(angle), sine = std::sin(angle);
    return cosine * v + sine * glm::cross(axis, v) + (1 - cosine) * glm::dot(axis, v) * axis;
}

/// What is interpolated of a keyframe: position, look_at, log tan(fov / 2).
template <class Value>
using Track = Value (*)(const Keyframe&);

DVec3 position_of(const Keyframe& key) { return DVec3(key.position); }
DVec3 look_at_of(const Keyframe& key) { return DVec3(key.look_at); }
double zoom_of(const Keyframe& key) { return std::log(std::tan(double(key.fov) / 2)); }

double length(double x) { return std::abs(x); }
double length(DVec3 x) { return glm::length(x); }

/// Mean velocity between keyframes i and i + 1, per frame.
template <class Value>
Value velocity(std::span<const Keyframe> keys, std::size_t i, Track<Value> value) {
    return (value(keys[i + 1]) - value(keys[i])) / double(keys[i + 1].frame - keys[i].frame);
}

/// Velocity at keyframe i.
template <class Value>
Value tangent(std::span<const Keyframe> keys, std::size_t i, Track<Value> value) {
    if (i == 0) return velocity(keys, 0, value);
    if (i + 1 == keys.size()) return velocity(keys, i - 1, value);
    const Value before = velocity(keys, i - 1, value), after = velocity(keys, i, value);
    const double h_before = keys[i].frame - keys[i - 1].frame,
                 h_after = keys[i + 1].frame - keys[i].frame;
    const Value parabola = (h_after * before + h_before * after) / (h_before + h_after);
    const double most = kLargestTangent * std::min(length(before), length(after));
    const double speed = length(parabola);
    return speed > most ? parabola * (most / speed) : parabola;
}

/// The Hermite spline between keyframes i and i + 1, t in [0, 1] of the way.
template <class Value>
Value follow(std::span<const Keyframe> keys, std::size_t i, double t, Track<Value> value) {
    const double h = keys[i + 1].frame - keys[i].frame, t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * value(keys[i]) + (3 * t2 - 2 * t3) * value(keys[i + 1]) +
           h * ((t3 - 2 * t2 + t) * tangent(keys, i, value) +
                (t3 - t2) * tangent(keys, i + 1, value));
}

Keyframe between(std::span<const Keyframe> keys, int frame) {
    const auto next = std::ranges::upper_bound(keys, frame, {}, &Keyframe::frame);
    if (next == keys.begin()) return keys.front();
    const auto i = std::size_t(next - keys.begin()) - 1;
    if (keys[i].frame == frame || next == keys.end()) return keys[i];
    const double t = double(frame - keys[i].frame) / (keys[i + 1].frame - keys[i].frame);
    const double zoom = follow<double>(keys, i, t, zoom_of);
    return {frame, Vec3(follow<DVec3>(keys, i, t, position_of)),
            Vec3(follow<DVec3>(keys, i, t, look_at_of)), float(2 * std::atan(std::exp(zoom)))};
}

void turn(Camera& camera, const Turntable& table) {
    const double angle = double(table.angle) * camera.frame / table.frames;
    const DVec3 centre(camera.look_at), axis(table.axis);
    camera.position = Vec3(centre + rotate(DVec3(camera.position) - centre, axis, angle));
    camera.up = Vec3(rotate(DVec3(camera.up), axis, angle));
}

void move(Camera& camera, std::span<const Keyframe> keys) {
    const Keyframe key = between(keys, camera.frame);
    camera.position = key.position, camera.look_at = key.look_at, camera.fov = key.fov;
}

}  // namespace

int frame_count(const Camera& camera) {
    return std::visit(Overloaded{
                          [](std::monostate) { return 1; },
                          [](const Turntable& table) { return table.frames; },
                          [](const std::vector<Keyframe>& keys) { return keys.back().frame + 1; },
                      },
                      camera.motion);
}

Camera camera_at(const Camera& camera, int frame) {
    Camera still{camera.name,
                 camera.position,
                 camera.look_at,
                 camera.up,
                 camera.fov,
                 camera.width,
                 camera.height,
                 camera.lens_radius,
                 camera.focus,
                 camera.focus_point,
                 {},
                 frame};
    std::visit(Overloaded{
                   [](std::monostate) {},
                   [&](const Turntable& table) { turn(still, table); },
                   [&](const std::vector<Keyframe>& keys) { move(still, keys); },
               },
               camera.motion);
    if (still.focus_point) {
        const DVec3 position(still.position);
        const DVec3 forward = glm::normalize(DVec3(still.look_at) - position);
        still.focus = float(glm::dot(DVec3(*still.focus_point) - position, forward));
    }
    return still;
}

}  // namespace tallow
