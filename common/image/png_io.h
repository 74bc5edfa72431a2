// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/image/image.h"

namespace tallow {

/// Maps linear radiance to display values in [0, 1], before the sRGB transfer curve: identity up to
/// kShoulder, then a smooth shoulder that approaches 1. Hue is kept: the largest channel is mapped
/// and the others scaled with it, then blended towards white as it saturates.
Rgb tone_map(Rgb radiance);

/// sRGB transfer curve (IEC 61966-2-1) of a linear value in [0, 1].
float srgb_encode(float linear);

/// Writes "R", "G", "B" and, if present, "A" times 2^exposure as tone-mapped 8-bit sRGB, over
/// black, with a fixed dither of half a level so that gradients do not band. `name.tmp`, then
/// rename. Throws OutputError.
void write_png(const std::filesystem::path& file, const Image& image, float exposure_stops = 0);

}  // namespace tallow
