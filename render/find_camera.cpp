// SPDX-License-Identifier: Apache-2.0
#include "render/find_camera.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/base/errors.h"

namespace tallow {

const Camera& find_camera(const Scene& scene, const std::string& name) {
    if (name.empty()) return scene.cameras.front();
    std::vector<std::string> names;
    for (const Camera& camera : scene.cameras) {
        if (camera.name == name) return camera;
        names.push_back(camera.name);
    }
    throw UsageError(
        fmt::format("--camera: expected one of {}, got '{}'", fmt::join(names, ", "), name));
}

}  // namespace tallow
