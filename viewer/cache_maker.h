// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/base/progress.h"
#include "common/base/stats.h"
#include "common/cloud/cache_io.h"
#include "common/exitance/scene_plan.h"

namespace tallow {

/// The cache in `file` if it is one of the scene; else it is made there, as tallow-precompute makes
/// it, in this process: so its progress is at hand, and closing the window stops it with what is
/// done kept for --resume. `scene` is as the file says, `planned` as it is to be shown.
///
/// Throws   InputError if there is a file that is no cache, or damaged: it is not replaced;
///          OutputError, Interrupted.
MappedCache current_cache(const Scene& scene, const ScenePlan& planned,
                          const SceneGeometry& geometry, const std::filesystem::path& file,
                          Progress& progress, Stats& stats);

}  // namespace tallow
