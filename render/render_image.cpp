// SPDX-License-Identifier: Apache-2.0
// Prepared scene and camera -> image, band of tiles by band.
#include "render/render_image.h"

#include <fmt/format.h>

#include "render/band_renderer.h"
#include "render/film.h"

namespace tallow {
namespace {

void report(const RenderCounts& counts, const ExitanceAccuracy& accuracy, Stats& stats,
            Progress& progress) {
    add_count(stats, "camera_rays", counts.camera_rays);
    add_count(stats, "exitance_points", counts.exitance_points);
    add_count(stats, "evaluations", std::int64_t(counts.evaluations));
    if (!accuracy.certified) return;
    add_count(stats, "repeated", counts.repeated);
    add_count(stats, "uncertified", counts.uncertified);
    if (counts.uncertified > 0)
        progress.note(fmt::format(
            "{} of {} sums could not be certified to {}: they are too dark for the table of the "
            "profile; layer error_bound holds for them, too",
            counts.uncertified, 3 * counts.exitance_points, accuracy.tolerance));
}

}  // namespace

Tile whole_image(const Camera& camera) { return {0, 0, camera.width, camera.height}; }

Image render_image(const PreparedScene& world, const Camera& camera, const RenderOptions& options,
                   Progress& progress, Stats& stats) {
    require_camera_outside(world.scene(), world.rays(), camera);
    const Tile& crop = options.crop;
    const View view{world, camera, options.samples};
    std::vector<Pixel> pixels(crop.pixels());
    RenderCounts counts;
    progress.begin("render", crop.pixels(), "pixels");
    for (const std::vector<Tile>& tiles : cut_into_bands(crop, options.samples)) {
        BandRenderer band(view, tiles, stats, counts);
        band.render();
        for (const TileRenderer& tile : band.tiles()) {
            place(tile.tile(), tile.pixels(), crop, pixels);
            progress.add(tile.tile().pixels());
            if (options.on_tile) options.on_tile(tile.tile(), tile.pixels());
        }
    }
    progress.end();
    report(counts, world.accuracy(), stats, progress);
    return develop(camera, crop, pixels, options.layers);
}

}  // namespace tallow
