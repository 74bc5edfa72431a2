// SPDX-License-Identifier: Apache-2.0
// File name in, linear pixels out: the extension picks the reader; what all formats have in common
// is checked here.
#include "common/image/read_image.h"

#include <fmt/format.h>

#include <limits>
#include <new>

#include "common/base/errors.h"
#include "common/base/read_file.h"
#include "common/image/exr_io.h"
#include "common/image/image_readers.h"

namespace tallow {
namespace {

std::string channel_names(const Image& image) {
    std::string names;
    for (const Channel& channel : image.channels)
        names += (names.empty() ? "" : ", ") + channel.name;
    return names;
}

RgbImage read_exr_rgb(const std::filesystem::path& file) {
    const std::string name = file.string();
    if (!std::filesystem::exists(file)) throw InputError(name + ": no such file");
    const Image image = read_exr(file);
    const auto* grey = image.find_channel("Y");
    const std::vector<float>* rgb[3] = {image.find_channel("R"), image.find_channel("G"),
                                        image.find_channel("B")};
    if (!rgb[0] && !rgb[1] && !rgb[2]) rgb[0] = rgb[1] = rgb[2] = grey;
    if (!rgb[0] || !rgb[1] || !rgb[2])
        throw InputError(fmt::format("{}: expected channels R, G and B, or Y alone, got {}", name,
                                     channel_names(image)));
    if (image.x0 != 0 || image.y0 != 0 || image.crop_width != image.width ||
        image.crop_height != image.height)
        throw InputError(name + ": expected a whole image, got a crop of one");
    // What the file can hold was judged by read_exr.
    require_image_size(name, image.width, image.height, 1, kMaxImagePixels);
    RgbImage result{image.width, image.height, std::vector<Rgb>(rgb[0]->size())};
    for (std::size_t i = 0; i < result.pixels.size(); ++i)
        result.pixels[i] = {(*rgb[0])[i], (*rgb[1])[i], (*rgb[2])[i]};
    return result;
}

/// Refuses NaN, infinity and negative light; makes one of both zeros.
void require_light(const std::string& name, RgbImage& image) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            float& v = image.pixels[i][c];
            if (!(v >= 0 && v <= std::numeric_limits<float>::max()))
                throw InputError(
                    fmt::format("{}: pixel ({}, {}): expected finite numbers >= 0, got {}", name,
                                i % std::size_t(image.width), i / std::size_t(image.width), v));
            v += 0.0f;
        }
}

RgbImage decode(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (extension == ".exr") return read_exr_rgb(file);
    if (extension == ".png") return decode_png(file.string(), read_file(file, "an image"));
    if (extension == ".hdr") return decode_hdr(file.string(), read_file(file, "an image"));
    throw InputError(fmt::format("{}: expected an image file .exr, .hdr or .png, got '{}'",
                                 file.string(), extension));
}

}  // namespace

void require_image_size(const std::string& name, std::int64_t width, std::int64_t height,
                        std::uint64_t bytes, std::uint64_t most_per_byte) {
    const auto pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide ||
        pixels > kMaxImagePixels)
        throw InputError(
            fmt::format("{}: expected 1 to {} pixels a side and at most {} in all, "
                        "got {} x {}",
                        name, kMaxImageSide, kMaxImagePixels, width, height));
    if (pixels / most_per_byte > bytes)
        throw InputError(fmt::format("{}: claims {} x {} pixels, more than {} bytes can hold", name,
                                     width, height, bytes));
}

RgbImage read_image(const std::filesystem::path& file) {
    try {
        RgbImage image = decode(file);
        require_light(file.string(), image);
        return image;
    } catch (const std::bad_alloc&) {
        throw InputError(file.string() + ": does not fit into memory");
    }
}

}  // namespace tallow
