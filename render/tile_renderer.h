// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "render/film.h"
#include "render/prepared_scene.h"
#include "render/primary_hits.h"

namespace tallow {

/// What is looked at, from where, with how many camera rays a pixel.
struct View {
    const PreparedScene& world;
    const Camera& camera;
    int samples;
    Quality quality = Quality::full;
    std::stop_token stop{};  ///< asked between tiles
};

/// The pixels of a tile, filled pass by pass, and what the camera rays of the pass have met. Each
/// function that adds a term does so for all hits of the pass. `view` must outlive it.
class TileRenderer {
public:
    TileRenderer(const View& view, const Tile& tile)
        : view_(view), tile_(tile), pixels_(tile.pixels()) {}

    /// Starts a pass.
    void find_hits(SampleRange range);
    /// Ends it: what was met is forgotten.
    void forget_hits() { hits_ = {}, vertices_ = {}; }

    /// The points of a body that were hit; `points` has room for all that are counted.
    std::size_t count_points(std::uint32_t object) const;
    void list_points(std::uint32_t object, ExitancePoint* points) const;

    /// Adds the exitance of a body; that of this tile's points starts at `next`.
    void add_multiple_scattering(std::uint32_t object, const Exitance& exitance, std::size_t next);
    void add_single_scattering(std::uint32_t object);
    void add_reflected_light();

    /// Gives all pixels of a draft's block what the first one sees in mirrors, where they see the
    /// same object. To be called when all terms have been added.
    void share_mirrors();

    /// Follows paths from opaque surfaces; what they meet of bodies waits for its exitance.
    void add_indirect_light();
    const std::vector<BodyVertex>& vertices() const { return vertices_; }
    /// Adds what this tile's vertices on a body send; their exitance starts at `next`.
    void add_light_of_body(std::uint32_t object, const Exitance& exitance, std::size_t next);

    const Tile& tile() const { return tile_; }
    const std::vector<Pixel>& pixels() const { return pixels_; }
    std::vector<Pixel> take_pixels() && { return std::move(pixels_); }

private:
    int shadow_rays() const;
    std::size_t block_of(std::size_t pixel) const;
    void add(const ShadingPoint& point, Rgb Pixel::*layer, Rgb radiance);
    void describe_surfaces();
    void add_seen_lights();

    const View& view_;
    Tile tile_;
    std::vector<Pixel> pixels_;
    PrimaryHits hits_;
    std::vector<BodyVertex> vertices_;
};

}  // namespace tallow
