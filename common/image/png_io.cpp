// SPDX-License-Identifier: Apache-2.0
// Image -> 8-bit PNG for people, through libpng's simplified interface, which reports errors as
// values where the other one jumps.
#include "common/image/png_io.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/base/check.h"
#include "common/base/errors.h"
#include "common/base/output_file.h"
#include "common/base/parallel.h"

namespace tallow {
namespace {

/// In [0, 1), evenly spread over any small neighbourhood of pixels.
/// Source: interleaved gradient noise, Jimenez 2014, "Next Generation Post Processing in Call of
/// Duty: Advanced Warfare".
double dither(int x, int y) {
    const auto fraction = [](double v) { return v - std::floor(v); };
    return fraction(52.9829189 * fraction(0.06711056 * x + 0.00583715 * y));
}

std::uint8_t quantize(float display, double threshold) {
    const double level = std::floor(255.0 * srgb_encode(display) + threshold);
    return static_cast<std::uint8_t>(std::clamp(level, 0.0, 255.0));
}

/// Rows from the top, R, G, B.
std::vector<std::uint8_t> encode_pixels(const Image& image, float exposure_stops) {
    const std::vector<float>*r = image.find_channel("R"), *g = image.find_channel("G"),
          *b = image.find_channel("B");
    TALLOW_CHECK(r && g && b, "a PNG needs R, G and B, the image has {} other channels",
                 image.channels.size());
    const float gain = std::exp2(exposure_stops);
    const auto width = static_cast<std::size_t>(image.crop_width);
    std::vector<std::uint8_t> pixels(3 * r->size());
    parallel_for(static_cast<std::size_t>(image.crop_height), 16, [&](std::size_t y) {
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t i = y * width + x;
            const Rgb display = tone_map(gain * Rgb((*r)[i], (*g)[i], (*b)[i]));
            const double threshold =
                dither(image.x0 + static_cast<int>(x), image.y0 + static_cast<int>(y));
            for (int c = 0; c < 3; ++c) pixels[3 * i + c] = quantize(display[c], threshold);
        }
    });
    return pixels;
}

}  // namespace

Rgb tone_map(Rgb radiance) {
    // The argument order makes NaN lose; the upper limit keeps infinity out of the divisions.
    const Rgb c = map(radiance, [](float v) {
        return std::min(std::numeric_limits<float>::max(), std::max(0.0f, v));
    });
    const float m = max_channel(c);
    if (m <= kShoulder) return c;
    const float shoulder = 1 - (1 - kShoulder) / (1 + (m - kShoulder) / (1 - kShoulder));
    const float compressed = 1 - shoulder / m;
    const float w = compressed * compressed;
    return map(c, [&](float v) { return shoulder * ((1 - w) * (v / m) + w); });
}

float srgb_encode(float linear) {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 1;
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float srgb_decode(float stored) {
    return stored <= 0.04045f ? stored / 12.92f : std::pow((stored + 0.055f) / 1.055f, 2.4f);
}

void write_png(const std::filesystem::path& file, const Image& image, float exposure_stops) {
    write_png(file, image.crop_width, image.crop_height, encode_pixels(image, exposure_stops));
}

void write_png(const std::filesystem::path& file, int width, int height,
               std::span<const std::uint8_t> rgb) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(width);
    png.height = static_cast<png_uint_32>(height);
    png.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string encoded(size, '\0');
    if (!png_image_write_to_memory(&png, encoded.data(), &size, 0, rgb.data(), 0, nullptr))
        throw OutputError(
            fmt::format("{}: cannot encode the image: {}", file.string(), png.message));
    encoded.resize(size);
    OutputFile output(file);
    output.write(encoded);
    output.commit();
}

}  // namespace tallow
