// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/base/progress.h"
#include "common/base/stats.h"
#include "common/image/image.h"
#include "render/film.h"
#include "render/prepared_scene.h"
#include "render/primary_hits.h"

namespace tallow {

/// One picture of a scene.
struct RenderOptions {
    Tile crop;         ///< pixels to render, inside the camera's image
    int samples = 16;  ///< camera rays a pixel
    std::vector<std::string> layers{};
    /// Told of each tile when it is done.
    std::function<void(const Tile&, std::span<const Pixel>)> on_tile{};
};

/// All pixels of a camera.
Tile whole_image(const Camera& camera);

/// Pass two: what a camera sees. The same image for any number of threads, and whatever was
/// rendered before. Adds times and counts to `stats`. Throws InputError, Interrupted.
Image render_image(const PreparedScene& world, const Camera& camera, const RenderOptions& options,
                   Progress& progress, Stats& stats);

}  // namespace tallow
