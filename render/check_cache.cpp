// SPDX-License-Identifier: Apache-2.0
// Cache and scene -> whether they belong together.
#include "render/check_cache.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/errors.h"
#include "common/cloud/scene_fingerprint.h"

namespace tallow {

std::vector<std::uint32_t> bodies_to_sample(const ScenePlan& planned) {
    std::vector<std::uint32_t> needed;
    for (std::uint32_t i = 0; i < planned.scene.objects.size(); ++i)
        if (subsurface(planned.scene, i) != nullptr && planned.treatment[i] == Treatment::samples)
            needed.push_back(i);
    return needed;
}

void require_cache_of(const ScenePlan& planned, const SceneGeometry& geometry,
                      const std::filesystem::path& file, const CacheView& cache) {
    require_fingerprint(file, cache.fingerprint, scene_fingerprint(planned.scene, geometry));
    for (const std::uint32_t object : bodies_to_sample(planned))
        if (std::ranges::find(cache.bodies, object, &BodyView::object) == cache.bodies.end())
            throw InputError(fmt::format(
                "{}: has no samples of objects[{}]: the cameras and the tolerance that "
                "it was made for did not need them; re-run tallow-precompute with these",
                file.string(), object));
}

}  // namespace tallow
