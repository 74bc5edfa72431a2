// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/cloud/cache_io.h"
#include "common/exitance/scene_plan.h"
#include "common/scene/scene_geometry.h"

namespace tallow {

/// Objects whose samples the picture needs: without any, it needs no cache.
std::vector<std::uint32_t> bodies_to_sample(const ScenePlan& planned);

/// Refuses a cache that was made from something else, or that lacks samples of a body that needs
/// them. Throws InputError, which begins with the file's name and says what to do.
void require_cache_of(const ScenePlan& planned, const SceneGeometry& geometry,
                      const std::filesystem::path& file, const CacheView& cache);

}  // namespace tallow
