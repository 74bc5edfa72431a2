// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "common/image/exr_io.h"

namespace tallow::test {

/// Writes the pixels, row by row from the top, as an EXR file, which keeps them exactly.
inline void write_picture(const std::filesystem::path& file, int width, int height,
                          const std::vector<Rgb>& pixels) {
    Image image = make_image(width, height);
    for (int c = 0; c < 3; ++c) {
        std::vector<float>& channel = image.add_channel(std::string(1, "RGB"[c]));
        for (std::size_t i = 0; i < pixels.size(); ++i) channel[i] = pixels[i][c];
    }
    write_exr(file, image);
}

}  // namespace tallow::test
