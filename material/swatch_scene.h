// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/scene/scene.h"

namespace tallow {

inline constexpr int kSwatchWidth = 128, kSwatchHeight = 192;  // pixels

/// A small stage that shows what a translucent material does to light, 12 mm across. Below, a block
/// under grazing light whose right half lies in the shadow of a thin fin: how far light creeps into
/// the shadow and out of the edges is the material's scale. On top a ball lit from behind.
Scene swatch_scene(const SubsurfaceMaterial& material);

}  // namespace tallow
