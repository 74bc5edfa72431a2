// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/base/progress.h"
#include "common/base/stats.h"
#include "common/scene/scene.h"
#include "precompute/checkpoint.h"
#include "precompute/choose_spacing.h"

namespace tallow {

struct PrecomputeOptions {
    SamplingWish sampling;
    Checkpoint::Options checkpoint{};
    bool plan_only = false;  ///< stop when the plan is made; no file is written
};

/// Pass one: scene -> samples, irradiance and octree of each translucent body -> cache file.
/// Times and counts go to `stats`. While it works, irradiance that is done is kept in CACHE.part,
/// for a run with options.checkpoint.resume. Direct light of a cache that is replaced is kept where
/// it is still right. Throws InputError, OutputError, Interrupted.
void precompute(const Scene& scene, const PrecomputeOptions& options,
                const std::filesystem::path& cache_file, Progress& progress, Stats& stats);

}  // namespace tallow
