// SPDX-License-Identifier: Apache-2.0
#include "viewer/camera_text.h"

#include <fmt/format.h>

namespace tallow {
namespace {

std::string point(const Scene& scene, Vec3 p) {
    const DVec3 q = (DVec3(p) + scene.origin) / double(scene.mm_per_unit);
    return fmt::format("[{}, {}, {}]", q.x, q.y, q.z);
}

}  // namespace

std::string camera_text(const Scene& scene, const Camera& camera, const std::string& name) {
    const bool has_lens = camera.lens_radius > 0;
    std::string entry = fmt::format(
        "{}: {{type: {}, position: {}, look_at: {}, up: [{}, {}, {}], fov_deg: {}, resolution: "
        "[{}, {}]",
        name, has_lens ? "thin-lens" : "perspective", point(scene, camera.position),
        point(scene, camera.look_at), camera.up.x, camera.up.y, camera.up.z,
        glm::degrees(camera.fov), camera.width, camera.height);
    if (has_lens)
        entry +=
            fmt::format(", aperture_mm: {}, focus_mm: {}", 2 * camera.lens_radius, camera.focus);
    return fmt::format("cameras:\n  {}}}\n", entry);
}

}  // namespace tallow
