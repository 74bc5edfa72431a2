// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "common/base/vec.h"
#include "common/scene/camera.h"

namespace tallow::reference {

/// A camera as something that light can be sent to.
class Pinhole {
public:
    explicit Pinhole(const Camera& camera)
        : position_(camera.position),
          forward_(glm::normalize(DVec3(camera.look_at) - DVec3(camera.position))),
          right_(glm::normalize(glm::cross(forward_, DVec3(camera.up)))),
          up_(glm::cross(right_, forward_)),
          pixel_size_(2 * std::tan(double(camera.fov) / 2) / camera.height),
          width_(camera.width),
          height_(camera.height) {}

    DVec3 position() const { return position_; }
    int width() const { return width_; }
    int height() const { return height_; }
    std::size_t pixels() const { return std::size_t(width_) * std::size_t(height_); }

    /// What a point looks like: in which pixel, and the pixel's mean radiance for an irradiance
    /// of 1 across the ray,
    ///
    ///     L = E / (pixel_size^2 cos^3 theta),   d omega = pixel_size^2 cos^3 theta d(pixels)
    ///
    /// with theta from the camera's axis and pixel_size at distance 1. Nothing outside the image.
    struct View {
        std::uint32_t pixel;  // y * width + x
        double radiance;      // 1/sr
    };
    std::optional<View> see(DVec3 p) const {
        const DVec3 d = p - position_;
        const double z = glm::dot(d, forward_);
        if (!(z > 0)) return std::nullopt;
        const double x = width_ / 2.0 + glm::dot(d, right_) / (z * pixel_size_);
        const double y = height_ / 2.0 - glm::dot(d, up_) / (z * pixel_size_);
        if (!(x >= 0 && x < width_ && y >= 0 && y < height_)) return std::nullopt;
        const double cosine = z / glm::length(d);
        return View{std::uint32_t(y) * std::uint32_t(width_) + std::uint32_t(x),
                    1 / (pixel_size_ * pixel_size_ * cosine * cosine * cosine)};
    }

private:
    DVec3 position_, forward_, right_, up_;
    double pixel_size_;
    int width_, height_;
};

}  // namespace tallow::reference
