// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/image/image.h"
#include "render/primary_hits.h"

namespace tallow {

/// Everything that is known of a pixel, averaged over its camera rays. Radiance layers sum to the
/// picture; the rest describes the surfaces seen directly.
struct Pixel {
    Rgb multiple;           // multiple scattering
    Rgb single;             // single scattering
    Rgb diffuse;            // light reflected by opaque surfaces
    Rgb specular;           // all that is seen in mirror reflections
    Rgb transmitted;        // all that is seen through bodies
    Rgb scattered;          // multiple and single, also in mirrors and through bodies
    Rgb emission;           // lights seen directly
    Rgb exitance;           // M of translucent surfaces, W/mm^2
    Rgb error_bound;        // of the exitance, against the plain sum over all samples
    Rgb albedo;             // share of light given back
    Vec3 normal{0};         // shading normal
    Vec3 position{0};       // mm
    float depth = 0;        // distance from the camera, mm
    float coverage = 0;     // share of rays that met a surface
    float evaluations = 0;  // kernel evaluations, all rays and channels

    Rgb radiance() const { return multiple + single + diffuse + specular + transmitted + emission; }
};

/// The pixels of a tile, row by row.
struct TilePixels {
    Tile tile;
    std::vector<Pixel> pixels;
};

/// What a pixel holds, times a factor; `evaluations`, which is no mean, stays.
Pixel scaled(Pixel pixel, float factor);

/// Puts the pixels of a tile into those of the crop that it is part of.
void place(const Tile& tile, std::span<const Pixel> from, const Tile& crop, std::span<Pixel> to);

/// Names of the layers that --aovs may ask for, in the order in which they are written.
std::span<const std::string> layer_names();

/// The picture ("R", "G", "B", "A") and the asked-for layers of the pixels in `crop` of an image of
/// the camera's size. pixels[] is row by row over the crop.
///
/// Throws   std::logic_error naming the pixel if a value is not finite.
Image develop(const Camera& camera, const Tile& crop, std::span<const Pixel> pixels,
              std::span<const std::string> layers);

}  // namespace tallow
