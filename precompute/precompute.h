// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "common/base/progress.h"
#include "common/base/stats.h"
#include "common/scene/scene.h"
#include "precompute/checkpoint.h"

namespace tallow {

struct PrecomputeOptions {
    std::optional<float> spacing;  ///< mm; without it chosen for each body, see automatic_spacing
    Checkpoint::Options checkpoint;
};

/// Spacing of samples for a medium and a tolerance: 0.35 of the smallest channel's mean free path
/// at 1 %, growing with the square root of the tolerance, because the error of a midpoint rule
/// grows with the square of the spacing. At most a fifth of the body's extent.
///
/// Units    mm.
float automatic_spacing(const Medium& medium, double tolerance, float extent);

/// Pass one: scene -> samples, irradiance and octree of each translucent body -> cache file.
/// Times and counts go to `stats`. While it works, irradiance that is done is kept in CACHE.part,
/// for a run with options.checkpoint.resume. Direct light of a cache that is replaced is kept where
/// it is still right. Throws InputError, OutputError, Interrupted.
void precompute(const Scene& scene, const PrecomputeOptions& options,
                const std::filesystem::path& cache_file, Progress& progress, Stats& stats);

}  // namespace tallow
