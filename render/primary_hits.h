// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/geometry/ray_scene.h"
#include "common/scene/scene.h"

namespace tallow {

/// A rectangle of pixels: x0 <= x < x1, y0 <= y < y1.
struct Tile {
    int x0, y0, x1, y1;
    int width() const { return x1 - x0; }
    std::size_t pixels() const { return std::size_t(x1 - x0) * std::size_t(y1 - y0); }
};

/// A surface seen in a pixel, directly, in mirrors or through bodies. hit.n faces w_o.
struct ShadingPoint {
    std::uint32_t pixel;       // index in the tile, row by row
    std::uint32_t depth;       // number of surfaces met before it; 0 is seen directly
    bool through;              // a body: the first surface that was met was passed, not mirrored
    std::uint32_t ray;         // number of the camera ray in its pixel
    std::uint64_t seed;        // of the random decisions made here
    std::uint64_t pixel_seed;  // the same for all camera rays of a pixel, at one depth
    Hit hit;
    Vec3 w_o;  // unit, towards where it is seen from
    Rgb throughput;
};

/// A light seen in a pixel, directly, in mirrors or through bodies.
struct SeenLight {
    std::uint32_t pixel;
    std::uint32_t depth;
    bool through;
    Rgb radiance;  // throughput applied
};

struct PrimaryHits {
    std::vector<ShadingPoint> points;  // neighbouring pixels follow one another
    std::vector<SeenLight> lights;
};

/// Most mirror reflections that a camera ray follows. Chosen: a path between two smooth dielectrics
/// carries less than 1e-10 by then; facing mirrors go dark beyond.
inline constexpr std::uint32_t kMaxMirrorDepth = 8;

/// Most reflections that a camera ray follows inside of a body, and most rays that one camera ray
/// becomes by passing bodies. Chosen: in a clear ball each reflection at less than grazing angles
/// keeps some percent.
inline constexpr int kMaxInnerReflections = 12, kMaxRays = 64;

/// Camera rays [first, end) of the `samples` that a pixel gets altogether.
struct SampleRange {
    int first, end, samples;
};

/// How much of a picture is computed: everything, or what has to be there at once while a camera
/// moves. A draft has no single scattering, no light that passes bodies unscattered, and no
/// light that opaque surfaces get from one another.
/// What mirrors show and direct light on opaque surfaces, with one shadow ray to each light, are
/// computed once for each object in a block of 2 x 2 pixels. Its camera rays are traced in packets,
/// so that ties between triangles are broken as neighbours have it.
enum class Quality { full, draft };

/// First pixel of a draft's block, for coordinates in the tile or in the image, whose tiles start
/// at even ones.
inline int first_of_block(int coordinate) { return coordinate & ~1; }

/// Sends a range of stratified camera rays through each pixel of a tile, from all over the lens if
/// there is one, and follows them over
/// mirror reflections: off mirrors, and off the smooth dielectric surface of plastics and bodies,
/// weighted with the Fresnel reflectance.
///
/// Bodies with clear[object] are passed as well: the ray is refracted in, keeps e^(-sigma_t s) of
/// what it carries, is reflected inside as Fresnel's equations say, and goes on as a ray of its own
/// wherever it is refracted out, to whatever stands there, other bodies and the same one again
/// included. Weights (throughputs and radiances) are divided by
/// range.samples.
///
/// Throws   InputError if the camera is inside a translucent body.
PrimaryHits find_primary_hits(const Scene& scene, const RayScene& rays, const Camera& camera,
                              const Tile& tile, SampleRange range,
                              const std::vector<bool>& clear = {}, Quality quality = Quality::full);

/// Refuses a camera inside a translucent body: the method sees bodies from outside. Of a lens the
/// centre and eight points of the rim are looked at. Throws InputError.
void require_camera_outside(const Scene& scene, const RayScene& rays, const Camera& camera);

}  // namespace tallow
