// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "common/base/vec.h"

namespace tallow {

/// A pinhole camera. Lengths in mm, `fov` is the vertical field of view in radians.
struct Camera {
    std::string name;
    Vec3 position;
    Vec3 look_at;
    Vec3 up;
    float fov;
    int width, height;  // pixels
};

/// Ray through the image at (x, y) in pixels; (0, 0) is the top left corner of the image, y runs
/// down. Unit direction.
Ray camera_ray(const Camera& camera, float x, float y);

}  // namespace tallow
