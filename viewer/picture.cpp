// SPDX-License-Identifier: Apache-2.0
// Frame -> what is on the screen.
#include "viewer/picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/image/png_io.h"

namespace tallow {
namespace {

// Colour scale for numbers: lightness grows evenly, so that it also reads in grey. Chosen.
constexpr std::array<Rgb, 6> kScale = {Rgb(0, 0, 0),
                                       Rgb(0.05f, 0.02f, 0.2f),
                                       Rgb(0.3f, 0.03f, 0.3f),
                                       Rgb(0.75f, 0.15f, 0.08f),
                                       Rgb(0.95f, 0.55f, 0.1f),
                                       Rgb(1, 1, 0.9f)};

Rgb on_scale(float value) {
    const float place = std::clamp(value, 0.0f, 1.0f) * float(kScale.size() - 1);
    const std::size_t low = std::min(std::size_t(place), kScale.size() - 2);
    const float t = place - float(low);
    return (1 - t) * kScale[low] + t * kScale[low + 1];
}

float relative_bound(const Pixel& pixel) {
    float largest = 0;
    for (int c = 0; c < 3; ++c)
        if (pixel.exitance[c] > 0)
            largest = std::max(largest, pixel.error_bound[c] / pixel.exitance[c]);
    return largest;
}

/// The sRGB curve as a table, for a million values a frame. Its steps are below a quarter of a
/// level where the curve is steepest.
class SrgbTable {
public:
    SrgbTable() {
        for (std::size_t i = 0; i < levels_.size(); ++i)
            levels_[i] =
                std::uint8_t(std::lround(255 * srgb_encode(float(i) / float(levels_.size() - 1))));
    }
    std::uint8_t operator()(float linear) const {
        const float place = std::clamp(linear, 0.0f, 1.0f) * float(levels_.size() - 1);
        return levels_[std::size_t(place + 0.5f)];
    }

private:
    std::array<std::uint8_t, 16384> levels_;
};

}  // namespace

Rgb shown_colour(const Pixel& pixel, const ViewFrame& frame, Aov aov, float exposure_stops) {
    const float gain = std::exp2(exposure_stops);
    switch (aov) {
        case Aov::beauty:
            return tone_map(gain * pixel.radiance());
        case Aov::multiple:
            return tone_map(gain * pixel.multiple);
        case Aov::single:
            return tone_map(gain * pixel.single);
        case Aov::specular:
            return tone_map(gain * pixel.specular);
        case Aov::exitance:
            return tone_map(gain * kInvPi * pixel.exitance);
        case Aov::error:
            return frame.certified ? on_scale(relative_bound(pixel) / frame.tolerance) : Rgb(0);
        case Aov::evaluations:
            break;
    }
    const float evaluations = pixel.evaluations / float(frame.samples);
    return on_scale(std::log2(1 + evaluations) / std::log2(kMostEvaluations));
}

Picture make_picture(const ViewFrame& frame, Aov aov, float exposure_stops) {
    static const SrgbTable srgb;
    Picture picture{frame.camera.width, frame.camera.height, {}};
    picture.rgb.resize(3 * std::size_t(picture.width) * std::size_t(picture.height));
    for (const TilePixels& tile : frame.tiles) {
        std::size_t next = 0;
        for (int y = tile.tile.y0; y < tile.tile.y1; ++y)
            for (int x = tile.tile.x0; x < tile.tile.x1; ++x, ++next) {
                const Rgb colour = shown_colour(tile.pixels[next], frame, aov, exposure_stops);
                std::uint8_t* at =
                    &picture
                         .rgb[3 * (std::size_t(y) * std::size_t(picture.width) + std::size_t(x))];
                for (int c = 0; c < 3; ++c) at[c] = srgb(colour[c]);
            }
    }
    return picture;
}

}  // namespace tallow
