// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/stats.h"
#include "render/tile_renderer.h"

namespace tallow {

/// What rendering took.
struct RenderCounts {
    std::int64_t camera_rays = 0;
    std::int64_t exitance_points = 0;  // on bodies that are seen
    std::int64_t repeated = 0;         // of Exitance
    std::int64_t uncertified = 0;      // of Exitance
    double evaluations = 0;            // of kernels
};

/// Tiles that are rendered together, one term of the shading sum after the other: exitance is
/// gathered for all their points at once, body by body, because neighbours share work.
class BandRenderer {
public:
    /// Adds the time of each term to `stats`, and to `counts`. All three must outlive it.
    BandRenderer(const View& view, std::span<const Tile> tiles, Stats& stats, RenderCounts& counts);

    /// Adds all camera rays of the view. Returns false if it was stopped: its pixels mean nothing.
    bool render();
    /// Adds some of them, the next after those that were added before, for pictures that get better
    /// while they are looked at. Returns false as render() does.
    bool add_samples(SampleRange range);

    const std::vector<TileRenderer>& tiles() const { return tiles_; }
    /// The pixels, moved out.
    std::vector<TilePixels> take_pixels() &&;

private:
    void add_indirect_light();
    void add_multiple_scattering(std::uint32_t object);
    void add_single_scattering(std::uint32_t object);
    void add_light_of_body(std::uint32_t object);
    template <class Work>
    void for_tiles(const char* phase, const Work& work);
    template <class Work>
    void for_bodies(const Work& work);

    const View& view_;
    std::vector<TileRenderer> tiles_;
    Stats& stats_;
    RenderCounts& counts_;
};

/// Bands of tiles, row by row, with so many camera rays each that neighbours meet in a band.
std::vector<std::vector<Tile>> cut_into_bands(const Tile& crop, int samples);

}  // namespace tallow
