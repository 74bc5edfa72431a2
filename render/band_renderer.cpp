// SPDX-License-Identifier: Apache-2.0
// Tiles -> their pixels: primary hits, then one term of the shading sum after the other on all of
// them.
#include "render/band_renderer.h"

#include <algorithm>
#include <numeric>

#include "common/base/parallel.h"

namespace tallow {
namespace {

constexpr int kTileSize = 32;

// Camera rays a pixel that are held in memory at once.
constexpr int kSamplesPerPass = 16;

// Camera rays that are held in memory at once. Chosen: many, so that neighbours meet in a band.
constexpr std::size_t kRaysPerBand = 1 << 18;

}  // namespace

BandRenderer::BandRenderer(const View& view, std::span<const Tile> tiles, Stats& stats,
                           RenderCounts& counts)
    : view_(view), stats_(stats), counts_(counts) {
    for (const Tile& tile : tiles) tiles_.emplace_back(view, tile);
}

bool BandRenderer::render() {
    for (int first = 0; first < view_.samples; first += kSamplesPerPass)
        if (!add_samples({first, std::min(first + kSamplesPerPass, view_.samples), view_.samples}))
            return false;
    return true;
}

bool BandRenderer::add_samples(SampleRange range) {
    for_tiles("primary", [&](TileRenderer& tile) { tile.find_hits(range); });
    if (view_.stop.stop_requested()) return false;
    for (const TileRenderer& tile : tiles_)
        counts_.camera_rays += std::int64_t(tile.tile().pixels()) * (range.end - range.first);
    PhaseTimer timer(stats_, "exitance");
    for_bodies([&](std::uint32_t object) { add_multiple_scattering(object); });
    timer.stop();
    if (view_.quality == Quality::full)
        for_bodies([&](std::uint32_t object) { add_single_scattering(object); });
    for_tiles("surface", [](TileRenderer& tile) { tile.add_reflected_light(); });
    if (view_.quality == Quality::full && view_.world.has_indirect_light()) add_indirect_light();
    if (view_.quality == Quality::draft)
        for_tiles("surface", [](TileRenderer& tile) { tile.share_mirrors(); });
    for (TileRenderer& tile : tiles_) tile.forget_hits();
    return !view_.stop.stop_requested();
}

void BandRenderer::add_indirect_light() {
    for_tiles("indirect", [](TileRenderer& tile) { tile.add_indirect_light(); });
    const PhaseTimer indirect_timer(stats_, "indirect");
    for_bodies([&](std::uint32_t object) { add_light_of_body(object); });
}

std::vector<TilePixels> BandRenderer::take_pixels() && {
    std::vector<TilePixels> result;
    for (TileRenderer& tile : tiles_)
        result.push_back({tile.tile(), std::move(tile).take_pixels()});
    return result;
}

void BandRenderer::add_multiple_scattering(std::uint32_t object) {
    if (view_.stop.stop_requested()) return;
    std::vector<std::size_t> first(tiles_.size() + 1);  // [tile] of its points
    parallel_for(tiles_.size(), 1,
                 [&](std::size_t i) { first[i + 1] = tiles_[i].count_points(object); });
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<ExitancePoint> points(first.back());
    parallel_for(tiles_.size(), 1,
                 [&](std::size_t i) { tiles_[i].list_points(object, points.data() + first[i]); });
    const Exitance exitance = view_.world.body(object)->exitance.gather(points);
    parallel_for(tiles_.size(), 1, [&](std::size_t i) {
        tiles_[i].add_multiple_scattering(object, exitance, first[i]);
    });
    for (const float count : exitance.evaluations) counts_.evaluations += count;
    counts_.exitance_points += std::int64_t(points.size());
    counts_.repeated += std::int64_t(exitance.repeated);
    counts_.uncertified += std::int64_t(exitance.uncertified);
}

void BandRenderer::add_single_scattering(std::uint32_t object) {
    if (view_.world.body(object)->material->single_scattering == Switch::off) return;
    for_tiles("single", [&](TileRenderer& tile) { tile.add_single_scattering(object); });
}

void BandRenderer::add_light_of_body(std::uint32_t object) {
    if (view_.stop.stop_requested()) return;
    std::vector<ExitancePoint> points;
    std::vector<std::size_t> first;  // [tile] of its points
    for (const TileRenderer& tile : tiles_) {
        first.push_back(points.size());
        for (const BodyVertex& vertex : tile.vertices())
            if (vertex.object == object) points.push_back({vertex.position, vertex.n, vertex.w_o});
    }
    const Exitance exitance = view_.world.body(object)->exitance.gather(points);
    parallel_for(tiles_.size(), 1,
                 [&](std::size_t i) { tiles_[i].add_light_of_body(object, exitance, first[i]); });
}

template <class Work>
void BandRenderer::for_tiles(const char* phase, const Work& work) {
    const PhaseTimer timer(stats_, phase);
    parallel_for(tiles_.size(), 1, [&](std::size_t i) {
        if (!view_.stop.stop_requested()) work(tiles_[i]);
    });
}

template <class Work>
void BandRenderer::for_bodies(const Work& work) {
    for (std::uint32_t object = 0; object < view_.world.scene().objects.size(); ++object)
        if (view_.world.body(object) != nullptr) work(object);
}

std::vector<std::vector<Tile>> cut_into_bands(const Tile& crop, int samples) {
    std::vector<std::vector<Tile>> bands;
    std::size_t rays = kRaysPerBand;
    for (int y = crop.y0; y < crop.y1; y += kTileSize)
        for (int x = crop.x0; x < crop.x1; x += kTileSize) {
            const Tile tile{x, y, std::min(x + kTileSize, crop.x1),
                            std::min(y + kTileSize, crop.y1)};
            if (rays >= kRaysPerBand) bands.emplace_back(), rays = 0;
            bands.back().push_back(tile);
            rays += tile.pixels() * std::size_t(std::min(samples, kSamplesPerPass));
        }
    return bands;
}

}  // namespace tallow
