// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "common/base/rgb.h"

namespace tallow {

/// One named channel of an image: "R", "multiple.G", "Z". Row by row from the top left.
struct Channel {
    std::string name;
    std::vector<float> values;  // [y * width + x]
};

/// A float image with named channels and metadata. `width` and `height` are of the whole image;
/// the channels hold the data window only.
struct Image {
    int width = 0, height = 0;                            // display window, pixels
    int x0 = 0, y0 = 0, crop_width = 0, crop_height = 0;  // data window
    std::vector<Channel> channels;
    std::vector<std::pair<std::string, std::string>> metadata;

    /// Adds a channel filled with zeros; the reference is valid until the next call.
    std::vector<float>& add_channel(std::string name);
    /// Null if there is none of this name.
    const std::vector<float>* find_channel(const std::string& name) const;
};

/// An image of one size, without channels.
Image make_image(int width, int height);

}  // namespace tallow
