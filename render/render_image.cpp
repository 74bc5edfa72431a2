// SPDX-License-Identifier: Apache-2.0
// Bands of tiles -> pixels: primary hits, then one term of the shading sum after the other on all
// hits of a band. Exitance is gathered body by body, so that the evaluator gets many neighbours.
#include "render/render_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>

#include "common/base/parallel.h"
#include "common/exitance/exit_factor.h"
#include "common/exitance/body_exitance.h"
#include "render/film.h"
#include "render/march_steps.h"
#include "render/shade.h"
#include "render/single_scatter.h"

namespace tallow {
namespace {

constexpr int kTileSize = 32;

// Camera rays a pixel that are held in memory at once.
constexpr int kSamplesPerPass = 16;

// Camera rays that are held in memory at once. Chosen: many, so that neighbours meet in a band.
constexpr std::size_t kRaysPerBand = 1 << 18;

// Paths of indirect light from opaque surfaces: so many a pixel, shared by its camera rays, but at
// least so many each.
constexpr int kPathsPerPixel = 64, kLeastPaths = 1;

/// A translucent body ready to be shaded.
struct Body {
    const SubsurfaceMaterial* material;
    SurfaceFactors factors;
    ExitanceField exitance;
    std::optional<RefractedConnections> connections;  // where single scattering is to be exact
    MarchSteps march_steps{};                         // of a camera ray, and of a pixel
};

struct Counts {
    std::int64_t camera_rays = 0, exitance_points = 0, repeated = 0, uncertified = 0;
    double evaluations = 0;
};

/// Everything that tiles are rendered from.
struct View {
    const Scene& scene;
    const Scene& lit;  // the same without the lights that are switched off
    const SceneGeometry& geometry;
    const RayScene& rays;
    const std::vector<std::optional<Body>>& bodies;  // [object]
    const ReflectedLight& reflected;
    const std::vector<Rgb>& albedos;  // [material]
    const Camera& camera;
    bool indirect;  // whether surfaces reflect light that was reflected before
    double tolerance;
};

/// The pixels of a tile, filled pass by pass, and what the camera rays of the pass have met.
class TileRenderer {
public:
    TileRenderer(const View& view, const Tile& tile)
        : view_(view), tile_(tile), pixels_(tile.pixels()) {}

    void find_hits(SampleRange range) {
        hits_ = find_primary_hits(view_.scene, view_.rays, view_.camera, tile_, range);
        describe_surfaces();
        add_seen_lights();
    }

    /// The points of a body that were hit.
    std::size_t count_points(std::uint32_t object) const {
        return std::size_t(
            std::count_if(hits_.points.begin(), hits_.points.end(),
                          [&](const ShadingPoint& point) { return point.hit.object == object; }));
    }
    void list_points(std::uint32_t object, ExitancePoint* points) const {
        const Body& body = *view_.bodies[object];
        for (const ShadingPoint& point : hits_.points) {
            if (point.hit.object != object) continue;
            *points = {point.hit.position, point.hit.n, point.w_o};
            if (body.exitance.needs_irradiance())
                points->E_direct = view_.reflected.entering(point, *body.material, shadow_rays());
            ++points;
        }
    }

    /// Adds the exitance of a body; that of this tile's points starts at `next`.
    void add_multiple_scattering(std::uint32_t object, const Exitance& exitance, std::size_t next) {
        const Body& body = *view_.bodies[object];
        const float weight = 1.0f / float(view_.scene.settings.samples);
        for (const ShadingPoint& point : hits_.points) {
            if (point.hit.object != object) continue;
            const float T = exit_factor(body.factors, glm::dot(point.hit.n, point.w_o));
            const Rgb tint = surface_tint(view_.scene, body.material->albedo, point.hit);
            add(point, &Pixel::multiple, kInvPi * T * tint * exitance.M[next]);
            Pixel& pixel = pixels_[point.pixel];
            if (point.depth == 0) {
                pixel.exitance += weight * tint * exitance.M[next];
                if (!exitance.bound.empty())
                    pixel.error_bound += weight * tint * exitance.bound[next];
            }
            pixel.evaluations += exitance.evaluations[next];
            ++next;
        }
    }

    void add_single_scattering(std::uint32_t object, MarchSteps steps) {
        const Body& body = *view_.bodies[object];
        std::vector<const ShadingPoint*> points;
        std::vector<EyePoint> eyes;
        for (const ShadingPoint& point : hits_.points) {
            if (point.hit.object != object) continue;
            points.push_back(&point);
            eyes.push_back({point.hit, point.w_o, point.pixel_seed,
                            point.ray * std::uint32_t(steps.of_point)});
        }
        std::vector<Rgb> L(points.size());
        single_scatter(
            {view_.lit, view_.rays, view_.geometry.surfaces[object], object, body.material->medium,
             body.connections ? &*body.connections : nullptr, body.material->albedo},
            eyes, steps, L);
        for (std::size_t i = 0; i < points.size(); ++i) add(*points[i], &Pixel::single, L[i]);
    }

    void add_reflected_light() {
        for (const ShadingPoint& point : hits_.points)
            if (!view_.bodies[point.hit.object])
                add(point, &Pixel::diffuse, view_.reflected.direct(point, shadow_rays()));
    }

    /// Follows paths from opaque surfaces; what they meet of bodies waits for its exitance.
    void add_indirect_light() {
        const int paths = std::max(kLeastPaths, kPathsPerPixel / view_.scene.settings.samples);
        vertices_.clear();
        for (std::size_t i = 0; i < hits_.points.size(); ++i)
            add(hits_.points[i], &Pixel::diffuse,
                view_.reflected.indirect(hits_.points[i], paths, std::uint32_t(i), vertices_));
    }
    const std::vector<BodyVertex>& vertices() const { return vertices_; }

    /// Adds what this tile's vertices on a body send; their exitance starts at `next`.
    void add_light_of_body(std::uint32_t object, const Exitance& exitance, std::size_t next) {
        for (const BodyVertex& vertex : vertices_)
            if (vertex.object == object)
                add(hits_.points[vertex.receiver], &Pixel::diffuse,
                    vertex.factor * exitance.M[next++]);
    }

    const Tile& tile() const { return tile_; }
    const std::vector<Pixel>& pixels() const { return pixels_; }

private:
    // To each area light.
    int shadow_rays() const {
        return std::max(1, shadow_rays_of_pixel(view_.tolerance) / view_.scene.settings.samples);
    }

    // Adds radiance seen at a point to its layer; what mirrors show belongs to their specular.
    void add(const ShadingPoint& point, Rgb Pixel::*layer, Rgb radiance) {
        pixels_[point.pixel].*(point.depth == 0 ? layer : &Pixel::specular) +=
            point.throughput * radiance;
    }

    void describe_surfaces() {
        const float weight = 1.0f / float(view_.scene.settings.samples);
        for (const ShadingPoint& point : hits_.points) {
            if (point.depth > 0) continue;
            Pixel& pixel = pixels_[point.pixel];
            pixel.coverage += weight;
            pixel.normal += weight * point.hit.n;
            pixel.position += weight * Vec3(DVec3(point.hit.position) + view_.scene.origin);
            pixel.depth += weight * point.hit.t;
            pixel.albedo += weight * texture_value(view_.scene, point.hit) *
                            view_.albedos[view_.scene.objects[point.hit.object].material];
        }
    }

    void add_seen_lights() {
        for (const SeenLight& light : hits_.lights)
            pixels_[light.pixel].*(light.depth == 0 ? &Pixel::emission : &Pixel::specular) +=
                light.radiance;
    }

    const View& view_;
    Tile tile_;
    std::vector<Pixel> pixels_;
    PrimaryHits hits_;
    std::vector<BodyVertex> vertices_;
};

/// Tiles that are rendered together, one term of the shading sum after the other: exitance is
/// gathered for all their points at once, because neighbours share work.
class BandRenderer {
public:
    BandRenderer(const View& view, std::span<const Tile> tiles, Stats& stats, Counts& counts)
        : view_(view), stats_(stats), counts_(counts) {
        for (const Tile& tile : tiles) tiles_.emplace_back(view, tile);
    }

    void render() {
        const int samples = view_.scene.settings.samples;
        for (int first = 0; first < samples; first += kSamplesPerPass)
            add_samples({first, std::min(first + kSamplesPerPass, samples), samples});
    }

    const std::vector<TileRenderer>& tiles() const { return tiles_; }

private:
    void add_samples(SampleRange range) {
        for_tiles("primary", [&](TileRenderer& tile) { tile.find_hits(range); });
        for (const TileRenderer& tile : tiles_)
            counts_.camera_rays += std::int64_t(tile.tile().pixels()) * (range.end - range.first);
        PhaseTimer timer(stats_, "exitance");
        for (std::uint32_t object = 0; object < view_.bodies.size(); ++object)
            if (view_.bodies[object]) add_multiple_scattering(object);
        timer.stop();
        for (std::uint32_t object = 0; object < view_.bodies.size(); ++object)
            if (view_.bodies[object]) add_single_scattering(object);
        for_tiles("surface", [](TileRenderer& tile) { tile.add_reflected_light(); });
        if (!view_.indirect) return;
        for_tiles("indirect", [](TileRenderer& tile) { tile.add_indirect_light(); });
        const PhaseTimer indirect_timer(stats_, "indirect");
        for (std::uint32_t object = 0; object < view_.bodies.size(); ++object)
            if (view_.bodies[object]) add_light_of_body(object);
    }

    template <class Work>
    void for_tiles(const char* phase, const Work& work) {
        const PhaseTimer timer(stats_, phase);
        parallel_for(tiles_.size(), 1, [&](std::size_t i) { work(tiles_[i]); });
    }

    void add_light_of_body(std::uint32_t object) {
        std::vector<ExitancePoint> points;
        std::vector<std::size_t> first;  // [tile] of its points
        for (const TileRenderer& tile : tiles_) {
            first.push_back(points.size());
            for (const BodyVertex& vertex : tile.vertices())
                if (vertex.object == object)
                    points.push_back({vertex.position, vertex.n, vertex.w_o});
        }
        const Exitance exitance = view_.bodies[object]->exitance.gather(points);
        parallel_for(tiles_.size(), 1, [&](std::size_t i) {
            tiles_[i].add_light_of_body(object, exitance, first[i]);
        });
    }

    void add_single_scattering(std::uint32_t object) {
        if (view_.bodies[object]->material->single_scattering == Switch::off) return;
        const MarchSteps steps = view_.bodies[object]->march_steps;
        for_tiles("single", [&](TileRenderer& tile) { tile.add_single_scattering(object, steps); });
    }

    void add_multiple_scattering(std::uint32_t object) {
        std::vector<std::size_t> first(tiles_.size() + 1);  // [tile] of its points
        parallel_for(tiles_.size(), 1,
                     [&](std::size_t i) { first[i + 1] = tiles_[i].count_points(object); });
        std::partial_sum(first.begin(), first.end(), first.begin());
        std::vector<ExitancePoint> points(first.back());
        parallel_for(tiles_.size(), 1, [&](std::size_t i) {
            tiles_[i].list_points(object, points.data() + first[i]);
        });
        const Exitance exitance = view_.bodies[object]->exitance.gather(points);
        parallel_for(tiles_.size(), 1, [&](std::size_t i) {
            tiles_[i].add_multiple_scattering(object, exitance, first[i]);
        });
        for (const float count : exitance.evaluations) counts_.evaluations += count;
        counts_.exitance_points += std::int64_t(points.size());
        counts_.repeated += std::int64_t(exitance.repeated);
        counts_.uncertified += std::int64_t(exitance.uncertified);
    }

    const View& view_;
    std::vector<TileRenderer> tiles_;
    Stats& stats_;
    Counts& counts_;
};

// Bands of tiles, row by row, with about kRaysPerBand camera rays each.
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

// What single scattering does not add, the exitance must hold.
Orders orders_of_exitance(const SubsurfaceMaterial& material) {
    return material.single_scattering == Switch::off ? Orders::all : Orders::two_and_more;
}

std::vector<std::optional<Body>> prepare_bodies(const Scene& scene, const SceneGeometry& geometry,
                                                const CacheView& cache, ExitanceAccuracy accuracy,
                                                Stats& stats) {
    std::vector<std::optional<Body>> bodies(scene.objects.size());
    std::int64_t samples = 0, lit = 0;
    for (const BodyView& view : cache.bodies) {
        const SubsurfaceMaterial* material = subsurface(scene, view.object);
        const LitSamples lit_samples = light_samples(
            view, scene.groups, indirect_bounces(scene) > 0 ? indirect_gain(*material) : Rgb(0));
        samples += std::int64_t(view.positions.size());
        lit += std::int64_t(lit_samples.position.size());
        bodies[view.object].emplace(Body{
            material,
            surface_factors(*material),
            BodyExitance(view, *material, orders_of_exitance(*material), ExitanceUse::seen)
                .field(lit_samples, accuracy),
            {}});
        const int steps =
            march_steps_of_pixel(material->model, material->medium, accuracy.tolerance);
        bodies[view.object]->march_steps = {std::max(1, steps / scene.settings.samples),
                                            std::max(steps, scene.settings.samples)};
        if (material->connection == Connection::exact)
            bodies[view.object]->connections.emplace(geometry.surfaces[view.object],
                                                     material->medium.eta);
    }
    stats.counts["samples"] = samples;
    stats.counts["lit_samples"] = lit;
    return bodies;
}

// Lights whose group has the scale 0 get no rays.
Scene without_dark_lights(Scene scene) {
    for (Light& light : scene.lights) light.off = max_channel(scene.groups[light.group].scale) == 0;
    return scene;
}

bool has_opaque_surface(const Scene& scene, const RenderOptions& options) {
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        if (subsurface(scene, i) == nullptr || (!options.diffuse.empty() && options.diffuse[i]))
            return true;
    return false;
}

void report(const Counts& counts, const ExitanceAccuracy& accuracy, Stats& stats,
            Progress& progress) {
    stats.counts["camera_rays"] = counts.camera_rays;
    stats.counts["exitance_points"] = counts.exitance_points;
    stats.counts["evaluations"] = std::int64_t(counts.evaluations);
    if (!accuracy.certified) return;
    stats.counts["repeated"] = counts.repeated;
    stats.counts["uncertified"] = counts.uncertified;
    if (counts.uncertified > 0)
        progress.note(fmt::format(
            "{} of {} sums could not be certified to {}: they are too dark for the table of the "
            "profile; layer error_bound holds for them, too",
            counts.uncertified, 3 * counts.exitance_points, accuracy.tolerance));
}

}  // namespace

Image render_image(const Scene& scene, const SceneGeometry& geometry, const CacheView& cache,
                   const RenderOptions& options, Progress& progress, Stats& stats) {
    const Camera& camera = scene.cameras[std::size_t(options.camera)];
    PhaseTimer bvh_timer(stats, "bvh");
    const RayScene rays(geometry.surfaces);
    bvh_timer.stop();
    require_camera_outside(scene, rays, camera);

    PhaseTimer prepare_timer(stats, "octree");
    const auto bodies = prepare_bodies(scene, geometry, cache, options.accuracy, stats);
    prepare_timer.stop();
    std::vector<Rgb> albedos;
    for (const Material& material : scene.materials) albedos.push_back(albedo(material));

    const Tile& crop = options.crop;
    const Scene lit = without_dark_lights(scene);
    const ReflectedLight reflected(lit, rays, indirect_bounces(scene), options.diffuse);
    const View view{scene,
                    lit,
                    geometry,
                    rays,
                    bodies,
                    reflected,
                    albedos,
                    camera,
                    indirect_bounces(scene) > 0 && has_opaque_surface(scene, options),
                    options.accuracy.tolerance};
    std::vector<Pixel> pixels(crop.pixels());
    Counts counts;
    progress.begin("render", crop.pixels(), "pixels");
    for (const std::vector<Tile>& tiles : cut_into_bands(crop, scene.settings.samples)) {
        BandRenderer band(view, tiles, stats, counts);
        band.render();
        for (const TileRenderer& rendered : band.tiles()) {
            const Tile& tile = rendered.tile();
            for (int y = tile.y0; y < tile.y1; ++y)
                std::copy_n(rendered.pixels().begin() + std::ptrdiff_t(y - tile.y0) * tile.width(),
                            tile.width(),
                            pixels.begin() + std::ptrdiff_t(y - crop.y0) * crop.width() +
                                (tile.x0 - crop.x0));
            progress.add(tile.pixels());
        }
    }
    progress.end();
    report(counts, options.accuracy, stats, progress);
    return develop(camera, crop, pixels, options.layers);
}

}  // namespace tallow
