// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "common/base/rgb.h"

namespace tallow {

/// A picture as textures and environments use it: linear light, no alpha, row by row from the top
/// left.
struct RgbImage {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;  // [y * width + x]

    Rgb at(int x, int y) const {
        return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)];
    }
};

/// Reads an EXR, PNG (8 or 16 bits; sRGB is made linear) or Radiance HDR file; its extension tells
/// which. Grey is spread over the channels, alpha is ignored.
///
/// Throws   InputError naming the file for one that is damaged, holds numbers that are negative or
///          not finite, or claims more pixels than a file of its size can hold.
RgbImage read_image(const std::filesystem::path& file);

}  // namespace tallow
