// SPDX-License-Identifier: Apache-2.0
// Camera -> rays through its pixels.
#include "common/scene/camera.h"

#include <cmath>

namespace tallow {
namespace {

/// Uniform points of the unit square to uniform points of the unit disc, neighbours to neighbours.
/// Source: Shirley, Chiu 1997, "A Low Distortion Map Between Disk and Square".
Vec2 to_disc(Vec2 u) {
    const Vec2 p = 2.0f * u - Vec2(1);
    if (p == Vec2(0)) return p;
    const bool wide = std::abs(p.x) > std::abs(p.y);
    const float r = wide ? p.x : p.y;
    const float phi = wide ? kPi / 4 * (p.y / p.x) : kPi / 2 - kPi / 4 * (p.x / p.y);
    return r * Vec2(std::cos(phi), std::sin(phi));
}

}  // namespace

CameraRays::CameraRays(const Camera& camera)
    : camera_(camera),
      forward_(glm::normalize(camera.look_at - camera.position)),
      right_(glm::normalize(glm::cross(forward_, camera.up))),
      up_(glm::cross(right_, forward_)),
      // Half the image height at distance 1 spans half the field of view; pixels are square.
      pixel_size_(2 * std::tan(camera.fov / 2) / static_cast<float>(camera.height)) {}

Ray CameraRays::operator()(float x, float y, Vec2 lens) const {
    const auto width = static_cast<float>(camera_.width);
    const auto height = static_cast<float>(camera_.height);
    const Vec3 direction =
        forward_ + (x - width / 2) * pixel_size_ * right_ + (height / 2 - y) * pixel_size_ * up_;
    if (camera_.lens_radius == 0) return {camera_.position, glm::normalize(direction)};
    // All rays of an image point meet where its central ray crosses the plane that is sharp.
    const Vec2 on_lens = camera_.lens_radius * to_disc(lens);
    const Vec3 offset = on_lens.x * right_ + on_lens.y * up_;
    return {camera_.position + offset, glm::normalize(camera_.focus * direction - offset)};
}

Ray camera_ray(const Camera& camera, float x, float y, Vec2 lens) {
    return CameraRays(camera)(x, y, lens);
}

}  // namespace tallow
