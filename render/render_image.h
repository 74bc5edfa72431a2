// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "common/base/progress.h"
#include "common/base/stats.h"
#include "common/cloud/cache_io.h"
#include "common/exitance/exitance_field.h"
#include "common/image/image.h"
#include "common/scene/scene_geometry.h"
#include "render/primary_hits.h"

namespace tallow {

struct RenderOptions {
    int camera = 0;  ///< index into Scene::cameras
    Tile crop;       ///< pixels to render, inside the camera's image
    std::vector<std::string> layers;
    ExitanceAccuracy accuracy;
    std::vector<std::optional<Rgb>> diffuse{};  ///< [object] of ScenePlan
};

/// Pass two: scene, geometry and cache -> image. The number of camera rays is the scene's.
/// The same image for any number of threads. Throws InputError, Interrupted.
Image render_image(const Scene& scene, const SceneGeometry& geometry, const CacheView& cache,
                   const RenderOptions& options, Progress& progress, Stats& stats);

}  // namespace tallow
