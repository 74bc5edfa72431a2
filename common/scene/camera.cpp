// SPDX-License-Identifier: Apache-2.0
#include "common/scene/camera.h"

#include <cmath>

namespace tallow {

Ray camera_ray(const Camera& camera, float x, float y) {
    const Vec3 forward = glm::normalize(camera.look_at - camera.position);
    const Vec3 right = glm::normalize(glm::cross(forward, camera.up));
    const Vec3 up = glm::cross(right, forward);
    // Half the image height at distance 1 spans half the field of view; pixels are square.
    const auto width = static_cast<float>(camera.width);
    const auto height = static_cast<float>(camera.height);
    const float pixel_size = 2 * std::tan(camera.fov / 2) / height;
    const Vec3 direction =
        forward + (x - width / 2) * pixel_size * right + (height / 2 - y) * pixel_size * up;
    return {camera.position, glm::normalize(direction)};
}

}  // namespace tallow
