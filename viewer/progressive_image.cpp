// SPDX-License-Identifier: Apache-2.0
// Prepared scene and camera -> frames.
#include "viewer/progressive_image.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/base/parallel.h"
#include "render/render_image.h"

namespace tallow {
namespace {

class Stopwatch {
public:
    double milliseconds() const {
        const std::chrono::duration<double, std::milli> elapsed =
            std::chrono::steady_clock::now() - start_;
        return elapsed.count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// The largest of bound / exitance; pixels that see no body have neither.
float largest_bound(const std::vector<TilePixels>& tiles) {
    float largest = 0;
    for (const TilePixels& tile : tiles)
        for (const Pixel& pixel : tile.pixels)
            for (int c = 0; c < 3; ++c)
                if (pixel.exitance[c] > 0)
                    largest = std::max(largest, pixel.error_bound[c] / pixel.exitance[c]);
    return largest;
}

void describe_accuracy(const PreparedScene& world, ViewFrame& frame) {
    frame.tolerance = world.accuracy().tolerance;
    frame.certified = world.accuracy().certified;
    if (frame.certified) frame.largest_bound = largest_bound(frame.tiles);
}

}  // namespace

ProgressiveImage::ProgressiveImage(const PreparedScene& world, Camera camera, int samples,
                                   std::stop_token stop)
    : camera_(std::move(camera)), view_{world, camera_, samples, Quality::full, std::move(stop)} {
    for (const std::vector<Tile>& tiles : cut_into_bands(whole_image(camera_), 1))
        bands_.emplace_back(view_, tiles, stats_, counts_);
}

bool ProgressiveImage::add_pass() {
    const Stopwatch watch;
    stats_.seconds.clear();
    const std::int64_t points_before = counts_.exitance_points;
    for (BandRenderer& band : bands_)
        if (!band.add_samples({done_, done_ + 1, view_.samples})) return false;
    ++done_;
    points_of_pass_ = counts_.exitance_points - points_before;
    milliseconds_ = watch.milliseconds();
    return true;
}

ViewFrame ProgressiveImage::frame() const {
    ViewFrame frame;
    frame.camera = camera_;
    frame.samples = done_;
    frame.wanted_samples = view_.samples;
    frame.shading_points = points_of_pass_;
    frame.seconds = stats_.seconds;
    frame.milliseconds = milliseconds_;
    for (const BandRenderer& band : bands_)
        for (const TileRenderer& tile : band.tiles()) frame.tiles.push_back({tile.tile(), {}});
    std::vector<const TileRenderer*> sources;
    for (const BandRenderer& band : bands_)
        for (const TileRenderer& tile : band.tiles()) sources.push_back(&tile);
    // Weights are those of all rays.
    const float factor = float(view_.samples) / float(done_);
    parallel_for(sources.size(), 1, [&](std::size_t t) {
        std::vector<Pixel>& pixels = frame.tiles[t].pixels;
        pixels.reserve(sources[t]->pixels().size());
        for (const Pixel& pixel : sources[t]->pixels()) pixels.push_back(scaled(pixel, factor));
    });
    describe_accuracy(view_.world, frame);
    return frame;
}

std::optional<ViewFrame> draw_draft(const PreparedScene& world, const Camera& camera, float scale,
                                    std::stop_token stop) {
    const Stopwatch watch;
    ViewFrame frame;
    frame.camera = camera;
    frame.camera.width = std::max(1, int(std::lround(float(camera.width) / scale)));
    frame.camera.height = std::max(1, int(std::lround(float(camera.height) / scale)));
    frame.scale = scale;
    frame.draft = true;
    const View view{world, frame.camera, 1, Quality::draft, std::move(stop)};
    Stats stats;
    RenderCounts counts;
    for (const std::vector<Tile>& tiles : cut_into_bands(whole_image(frame.camera), 1)) {
        BandRenderer band(view, tiles, stats, counts);
        if (!band.render()) return std::nullopt;
        for (TilePixels& tile : std::move(band).take_pixels())
            frame.tiles.push_back(std::move(tile));
    }
    frame.shading_points = counts.exitance_points;
    frame.seconds = stats.seconds;
    describe_accuracy(world, frame);
    frame.milliseconds = watch.milliseconds();
    return frame;
}

}  // namespace tallow
