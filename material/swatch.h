// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "common/base/progress.h"
#include "common/base/stats.h"
#include "common/image/image.h"
#include "common/scene/scene.h"

namespace tallow {

/// Renders swatch_scene() of each material, one column each, side by side. Both passes run inside;
/// the cache between them is a file beside `output` that is removed again.
///
/// Throws   OutputError, Interrupted.
Image render_swatches(const std::vector<SubsurfaceMaterial>& materials,
                      const std::filesystem::path& output, Progress& progress, Stats& stats);

/// Writes a picture as .png or .exr, by its name.
void write_picture(const std::filesystem::path& file, const Image& image);

}  // namespace tallow
