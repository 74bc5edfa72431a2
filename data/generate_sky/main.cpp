// SPDX-License-Identifier: Apache-2.0
//
// tallow-sky out.exr
//
// Paints the clear sky of an early evening as a latitude-longitude picture, the sun in its middle.
// Brightness follows the CIE's clear sky; the colours are chosen to look like one. In units of the
// sky's own mean: the irradiance by the sky alone on level ground is pi.
//
// Source   ISO 15469:2004 / CIE S 011, "Spatial distribution of daylight - CIE standard general
//          sky", type 12.

#include <cmath>
#include <exception>
#include <iostream>
#include <numbers>

#include "common/base/vec.h"
#include "common/image/exr_io.h"

namespace tallow {
namespace {

constexpr int kWidth = 256, kHeight = 128, kSubpixels = 8;
constexpr double kPiD = std::numbers::pi;

// All chosen. The true sun has a radius of 0.27 degrees, less than a pixel.
constexpr double kSunElevation = 22 * kPiD / 180, kSunRadius = 1.6 * kPiD / 180;
constexpr double kSunOverSky = 2.5;  // irradiance across the sun's rays over pi
const DVec3 kSunColor(1, 0.8, 0.55), kZenithColor(0.45, 0.66, 1.05), kHorizonColor(1.02, 1, 0.96),
    kGlowColor(1.1, 0.98, 0.8), kGroundColor(0.2, 0.17, 0.13);

const DVec3 kToSun(0, std::sin(kSunElevation), std::cos(kSunElevation));

/// Luminance of the CIE's clear sky, of low turbidity, up to a factor.
double clear_sky(DVec3 w) {
    constexpr double a = -1, b = -0.32, c = 10, d = -3, e = 0.45;
    const double cos_zenith = std::max(w.y, 1e-3);
    const double cos_sun = std::clamp(glm::dot(w, kToSun), -1.0, 1.0), to_sun = std::acos(cos_sun);
    const double gradation = 1 + a * std::exp(b / cos_zenith);
    const double indicatrix =
        1 + c * (std::exp(d * to_sun) - std::exp(d * kPiD / 2)) + e * cos_sun * cos_sun;
    return gradation * indicatrix;
}

DVec3 sky_color(DVec3 w) {
    const double low = std::pow(1 - std::max(w.y, 0.0), 3);  // 1 at the horizon
    const double near = std::exp(-4 * std::acos(std::clamp(glm::dot(w, kToSun), -1.0, 1.0)));
    return glm::mix(glm::mix(kZenithColor, kHorizonColor, low), kGlowColor, near);
}

/// f over the directions of a picture: mean over each pixel's subpixels.
template <class F>
DVec3 pixel_mean(int x, int y, F&& f) {
    DVec3 sum(0.0);
    for (int i = 0; i < kSubpixels * kSubpixels; ++i) {
        const double u = (x + (i % kSubpixels + 0.5) / kSubpixels) / kWidth;
        const double v = (y + (i / kSubpixels + 0.5) / kSubpixels) / kHeight;
        const double longitude = kPiD - 2 * kPiD * u, sine = std::sin(kPiD * v);
        sum += f(DVec3(sine * std::sin(longitude), std::cos(kPiD * v), sine * std::cos(longitude)));
    }
    return sum / double(kSubpixels * kSubpixels);
}

/// Irradiance by clear_sky() on level ground.
double level_irradiance() {
    double sum = 0;
    for (int y = 0; y < kHeight / 2; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const double sine = std::sin(kPiD * (y + 0.5) / kHeight);
            sum += pixel_mean(x, y, [&](DVec3 w) { return DVec3(clear_sky(w) * w.y); }).x * sine;
        }
    return sum * (kPiD / kHeight) * (2 * kPiD / kWidth);
}

/// Rounded to 11 binary digits, as halves have: the rest would only be stored.
float few_digits(double v) {
    int exponent = 0;
    const double mantissa = std::frexp(v, &exponent);
    return float(std::ldexp(std::round(mantissa * 2048) / 2048, exponent));
}

Image paint_sky() {
    const double to_unit = kPiD / level_irradiance();
    const double cos_radius = std::cos(kSunRadius);
    const DVec3 sun = kSunOverSky * kPiD / (2 * kPiD * (1 - cos_radius)) * kSunColor;
    const DVec3 ground = kGroundColor * (1 + kSunOverSky * kToSun.y);
    Image image = make_image(kWidth, kHeight);
    for (const char* name : {"R", "G", "B"}) image.add_channel(name);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const DVec3 color = pixel_mean(x, y, [&](DVec3 w) {
                if (w.y < 0) return ground;
                const bool in_sun = glm::dot(w, kToSun) > cos_radius;
                return to_unit * clear_sky(w) * sky_color(w) + (in_sun ? sun : DVec3(0.0));
            });
            for (int c = 0; c < 3; ++c)
                image.channels[std::size_t(c)].values[std::size_t(y * kWidth + x)] =
                    few_digits(color[c]);
        }
    return image;
}

}  // namespace
}  // namespace tallow

int main(int argc, char** argv) {
    if (argc != 2) {
        std::cerr << "usage: tallow-sky out.exr\n";
        return 2;
    }
    try {
        tallow::write_exr(argv[1], tallow::paint_sky());
        return 0;
    } catch (const std::exception& e) {
        std::cerr << "tallow-sky: " << e.what() << "\n";
        return 1;
    }
}
