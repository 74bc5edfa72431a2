// SPDX-License-Identifier: Apache-2.0
#include "common/image/image.h"

#include <algorithm>

#include "common/base/check.h"

namespace tallow {

std::vector<float>& Image::add_channel(std::string name) {
    TALLOW_CHECK(find_channel(name) == nullptr, "channel '{}' exists", name);
    const std::size_t pixels =
        static_cast<std::size_t>(crop_width) * static_cast<std::size_t>(crop_height);
    channels.push_back({std::move(name), std::vector<float>(pixels)});
    return channels.back().values;
}

const std::vector<float>* Image::find_channel(const std::string& name) const {
    const auto found = std::find_if(channels.begin(), channels.end(),
                                    [&](const Channel& c) { return c.name == name; });
    return found == channels.end() ? nullptr : &found->values;
}

Image make_image(int width, int height) {
    TALLOW_CHECK(width > 0 && height > 0, "{} x {} pixels", width, height);
    Image image;
    image.width = image.crop_width = width;
    image.height = image.crop_height = height;
    return image;
}

}  // namespace tallow
