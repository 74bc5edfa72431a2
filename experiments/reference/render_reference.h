// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "common/base/tool_main.h"
#include "common/image/image.h"
#include "common/scene/scene_geometry.h"
#include "experiments/reference/bodies.h"

namespace tallow::reference {

/// How long to go on: until the first of these is reached, but for at least 16 batches.
struct Options {
    std::optional<double> noise;    ///< relative standard error of the pixels
    std::optional<double> paths;    ///< walks from the lamps
    std::optional<double> seconds;  ///< of all runs that were joined
    std::uint64_t seed = 1;
    bool camera_only = false;          ///< without links, as a check
    std::filesystem::path checkpoint;  ///< written every minute, at the end and on Ctrl-C
    bool resume = false;               ///< goes on from the checkpoint
    std::uint32_t walks = 1 << 16;     ///< from the lamps, of each channel in a batch
    Detail detail;
};

/// The picture of a scene, linear radiance, with layers
///
///     R, G, B                   all light that was scattered: single + multi + ext
///     A                         part of the pixel that bodies cover
///     single, multi, ext        see Layer
///     mirror                    light that was not scattered; not in R, G, B
///     variance, L_variance      of the means R, G, B and of those of layer L
///
/// and metadata on how it was made. The same for any number of threads, unless time stops it.
///
/// Throws   InputError for what Bodies and Lamps refuse, and for a checkpoint of something else.
Image render_reference(const Scene& scene, const SceneGeometry& geometry, const Camera& camera,
                       const Options& options, ToolRun& run);

}  // namespace tallow::reference
