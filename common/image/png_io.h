// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "common/image/image.h"

namespace tallow {

/// Radiance up to which tone_map() changes nothing. Chosen: with a lower one mid-tones lose their
/// contrast, with a higher one highlights lose their drawing.
inline constexpr float kShoulder = 0.8f;

/// Maps linear radiance to display values in [0, 1], before the sRGB transfer curve.
///
///     m         = largest channel,  s = kShoulder,  x = (m - s) / (1 - s)
///     shoulder  = m                          for m <= s
///                 s + (1 - s) x / (1 + x)    for m > s; slope 1 at s, approaches 1
///     w         = (1 - shoulder / m)^2       0 up to s, approaches 1
///     result    = shoulder * ((1 - w) * radiance / m + w)
///
/// Hue is kept: all channels are scaled with the largest and then blended towards white of the same
/// value. Each channel grows with exposure; a grey stays grey.
///
/// Domain   any float; negative and NaN channels count as 0.
Rgb tone_map(Rgb radiance);

/// sRGB transfer curve of a linear value. Domain: clamped to [0, 1]. Source: IEC 61966-2-1.
float srgb_encode(float linear);

/// Its inverse: linear value of a stored one. Domain: [0, 1].
float srgb_decode(float stored);

/// Writes the data window of "R", "G", "B" times 2^exposure_stops as tone-mapped 8-bit sRGB over
/// black; alpha is associated, so the colours are already what black shows through. A fixed dither
/// of one level keeps gradients from banding; it depends on the pixel's place in the whole image
/// only, and keeps black, white and greys what they are. `name.tmp`, then rename. Throws
/// OutputError.
void write_png(const std::filesystem::path& file, const Image& image, float exposure_stops = 0);

/// Writes 8-bit sRGB, `rgb` [3 * (y * width + x) + channel], as it is. `name.tmp`, then rename.
/// Throws OutputError.
void write_png(const std::filesystem::path& file, int width, int height,
               std::span<const std::uint8_t> rgb);

}  // namespace tallow
