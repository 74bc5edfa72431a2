// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "viewer/view_frame.h"
#include "viewer/view_state.h"

namespace tallow {

/// 8-bit sRGB, row by row from the top left.
struct Picture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // [3 * (y * width + x) + channel]
};

/// Kernel evaluations a camera ray that the top of the colour scale stands for; the scale is
/// logarithmic from 1.
inline constexpr float kMostEvaluations = 65536;

/// What a pixel shows, in display values before the sRGB curve: radiance through tone_map(), the
/// exitance as the radiance M / pi of a surface that sends as much everywhere; the error bound over
/// the tolerance (0 to 1) and the logarithm of the evaluations through a colour scale from black
/// over violet and orange to white.
Rgb shown_colour(const Pixel& pixel, const ViewFrame& frame, Aov aov, float exposure_stops);

/// The frame as it is shown, at its own resolution.
Picture make_picture(const ViewFrame& frame, Aov aov, float exposure_stops);

}  // namespace tallow
