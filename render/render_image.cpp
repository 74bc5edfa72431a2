// SPDX-License-Identifier: Apache-2.0
// Tiles -> pixels: primary hits, then one term of the shading sum after the other on all hits of a
// tile. Exitance is gathered body by body, so that the evaluator gets batches of neighbours.
#include "render/render_image.h"

#include <array>
#include <chrono>
#include <optional>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "render/film.h"
#include "render/gather_exitance.h"
#include "render/shade.h"
#include "render/single_scatter.h"

namespace tallow {
namespace {

constexpr int kTileSize = 32;

// Camera rays a pixel that a tile holds in memory at once: 16 take about 2 MB a thread.
constexpr int kSamplesPerPass = 16;

// Depths of the ray march through a body and shadow rays to each area light on opaque surfaces: so
// many a pixel, shared by its camera rays, but at least so many each. Chosen: 64 depths leave 0.1
// to 0.4 % of single scattering as noise (table in single_scatter.h).
constexpr int kMarchStepsPerPixel = 64, kLeastMarchSteps = 4;
constexpr int kShadowRaysPerPixel = 64, kLeastShadowRays = 1;

/// A translucent body ready to be shaded.
struct Body {
    const SubsurfaceMaterial* material;
    SurfaceFactors factors;
    ExitanceField exitance;
    std::optional<RefractedConnections> connections;  // where single scattering is to be exact
};

/// Seconds of thread time in each phase of a tile, and what was counted.
struct TileCost {
    double primary = 0, exitance = 0, single = 0, surface = 0;
    std::int64_t camera_rays = 0, exitance_points = 0, evaluations = 0;
};

class Stopwatch {
public:
    /// Seconds since construction or the last call.
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        const double seconds = std::chrono::duration<double>(now - start_).count();
        start_ = now;
        return seconds;
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class TileRenderer {
public:
    TileRenderer(const Scene& scene, const SceneGeometry& geometry, const RayScene& rays,
                 const std::vector<std::optional<Body>>& bodies, const std::vector<Rgb>& albedos,
                 const Camera& camera, const Tile& tile)
        : scene_(scene),
          geometry_(geometry),
          rays_(rays),
          bodies_(bodies),
          albedos_(albedos),
          camera_(camera),
          tile_(tile),
          pixels_(tile.pixels()) {}

    std::vector<Pixel> render(TileCost& cost) {
        const int samples = scene_.settings.samples;
        for (int first = 0; first < samples; first += kSamplesPerPass) {
            if (interrupted()) throw Interrupted();
            add_samples({first, std::min(first + kSamplesPerPass, samples), samples}, cost);
        }
        cost.camera_rays = std::int64_t(tile_.pixels()) * samples;
        return std::move(pixels_);
    }

private:
    void add_samples(SampleRange range, TileCost& cost) {
        Stopwatch watch;
        hits_ = find_primary_hits(scene_, rays_, camera_, tile_, range);
        describe_surfaces();
        add_seen_lights();
        cost.primary += watch.lap();
        for (std::uint32_t object = 0; object < bodies_.size(); ++object)
            if (bodies_[object]) add_multiple_scattering(object, cost);
        cost.exitance += watch.lap();
        add_single_scattering();
        cost.single += watch.lap();
        add_reflected_light();
        cost.surface += watch.lap();
    }

    // Adds radiance seen at a point to its layer; what mirrors show belongs to their specular.
    void add(const ShadingPoint& point, Rgb Pixel::*layer, Rgb radiance) {
        pixels_[point.pixel].*(point.depth == 0 ? layer : &Pixel::specular) +=
            point.throughput * radiance;
    }

    void describe_surfaces() {
        const float weight = 1.0f / float(scene_.settings.samples);
        for (const ShadingPoint& point : hits_.points) {
            if (point.depth > 0) continue;
            Pixel& pixel = pixels_[point.pixel];
            pixel.coverage += weight;
            pixel.normal += weight * point.hit.n;
            pixel.position += weight * Vec3(DVec3(point.hit.position) + scene_.origin);
            pixel.depth += weight * point.hit.t;
            pixel.albedo += weight * albedos_[scene_.objects[point.hit.object].material];
        }
    }

    void add_seen_lights() {
        for (const SeenLight& light : hits_.lights)
            pixels_[light.pixel].*(light.depth == 0 ? &Pixel::emission : &Pixel::specular) +=
                light.radiance;
    }

    void add_multiple_scattering(std::uint32_t object, TileCost& cost) {
        const Body& body = *bodies_[object];
        std::vector<std::size_t> indices;
        std::vector<ExitancePoint> points;
        for (std::size_t i = 0; i < hits_.points.size(); ++i) {
            const ShadingPoint& point = hits_.points[i];
            if (point.hit.object != object) continue;
            indices.push_back(i);
            points.push_back({point.hit.position, point.hit.n, point.w_o});
        }
        std::vector<Rgb> exitance(points.size());
        std::vector<std::uint32_t> evaluations(points.size());
        body.exitance.gather(points, exitance, evaluations);

        const float weight = 1.0f / float(scene_.settings.samples);
        for (std::size_t k = 0; k < indices.size(); ++k) {
            const ShadingPoint& point = hits_.points[indices[k]];
            const float T = exit_factor(body.factors, glm::dot(point.hit.n, point.w_o));
            add(point, &Pixel::multiple, kInvPi * T * exitance[k]);
            Pixel& pixel = pixels_[point.pixel];
            if (point.depth == 0) pixel.exitance += weight * exitance[k];
            pixel.evaluations += float(evaluations[k]);
            cost.evaluations += evaluations[k];
        }
        cost.exitance_points += std::int64_t(points.size());
    }

    void add_single_scattering() {
        const int steps = std::max(kLeastMarchSteps, kMarchStepsPerPixel / scene_.settings.samples);
        for (const ShadingPoint& point : hits_.points) {
            const auto& body = bodies_[point.hit.object];
            if (!body || body->material->single_scattering == Switch::off) continue;
            add(point, &Pixel::single,
                single_scatter(scene_, rays_, geometry_.surfaces[point.hit.object],
                               body->material->medium, point.hit, point.w_o, steps, point.seed,
                               body->connections ? &*body->connections : nullptr));
        }
    }

    void add_reflected_light() {
        const int light_samples =
            std::max(kLeastShadowRays, kShadowRaysPerPixel / scene_.settings.samples);
        for (const ShadingPoint& point : hits_.points)
            if (!bodies_[point.hit.object])
                add(point, &Pixel::diffuse,
                    reflect_direct_light(scene_, rays_, point, light_samples));
    }

    const Scene& scene_;
    const SceneGeometry& geometry_;
    const RayScene& rays_;
    const std::vector<std::optional<Body>>& bodies_;
    const std::vector<Rgb>& albedos_;
    const Camera& camera_;
    Tile tile_;
    std::vector<Pixel> pixels_;
    PrimaryHits hits_;
};

std::vector<Tile> cut_into_tiles(const Tile& crop) {
    std::vector<Tile> tiles;
    for (int y = crop.y0; y < crop.y1; y += kTileSize)
        for (int x = crop.x0; x < crop.x1; x += kTileSize)
            tiles.push_back(
                {x, y, std::min(x + kTileSize, crop.x1), std::min(y + kTileSize, crop.y1)});
    return tiles;
}

// What single scattering does not add, the exitance must hold.
Orders orders_of_exitance(const SubsurfaceMaterial& material) {
    return material.single_scattering == Switch::off ? Orders::all : Orders::two_and_more;
}

std::vector<std::optional<Body>> prepare_bodies(const Scene& scene, const SceneGeometry& geometry,
                                                const CacheView& cache, Stats& stats) {
    std::vector<std::optional<Body>> bodies(scene.objects.size());
    std::int64_t samples = 0, lit = 0;
    for (const BodyView& view : cache.bodies) {
        const SubsurfaceMaterial* material = subsurface(scene, view.object);
        const LitSamples lit_samples = light_samples(view, scene.groups);
        samples += std::int64_t(view.positions.size());
        lit += std::int64_t(lit_samples.position.size());
        bodies[view.object].emplace(Body{
            material,
            surface_factors(*material),
            ExitanceField(
                lit_samples,
                tabulate_profiles(material->model, material->medium, orders_of_exitance(*material)),
                scene.settings.tolerance),
            {}});
        if (material->connection == Connection::exact)
            bodies[view.object]->connections.emplace(geometry.surfaces[view.object],
                                                     material->medium.eta);
    }
    stats.counts["samples"] = samples;
    stats.counts["lit_samples"] = lit;
    return bodies;
}

void report(Stats& stats, const std::vector<TileCost>& costs, int threads) {
    TileCost sum;
    for (const TileCost& cost : costs) {
        sum.primary += cost.primary, sum.exitance += cost.exitance;
        sum.single += cost.single, sum.surface += cost.surface;
        sum.camera_rays += cost.camera_rays;
        sum.exitance_points += cost.exitance_points;
        sum.evaluations += cost.evaluations;
    }
    stats.seconds["primary"] = sum.primary / threads;
    stats.seconds["exitance"] = sum.exitance / threads;
    stats.seconds["single"] = sum.single / threads;
    stats.seconds["surface"] = sum.surface / threads;
    stats.counts["camera_rays"] = sum.camera_rays;
    stats.counts["exitance_points"] = sum.exitance_points;
    stats.counts["evaluations"] = sum.evaluations;
}

}  // namespace

Image render_image(const Scene& scene, const SceneGeometry& geometry, const CacheView& cache,
                   const RenderOptions& options, Progress& progress, Stats& stats, int threads) {
    const Camera& camera = scene.cameras[std::size_t(options.camera)];
    PhaseTimer bvh_timer(stats, "bvh");
    const RayScene rays(geometry.surfaces);
    bvh_timer.stop();
    require_camera_outside(scene, rays, camera);

    PhaseTimer prepare_timer(stats, "octree");
    const auto bodies = prepare_bodies(scene, geometry, cache, stats);
    prepare_timer.stop();
    std::vector<Rgb> albedos;
    for (const Material& material : scene.materials) albedos.push_back(albedo(material));

    const Tile& crop = options.crop;
    const std::vector<Tile> tiles = cut_into_tiles(crop);
    std::vector<Pixel> pixels(crop.pixels());
    std::vector<TileCost> costs(tiles.size());
    progress.begin("render", tiles.size(), "tiles");
    parallel_for(tiles.size(), 1, [&](std::size_t t) {
        const Tile& tile = tiles[t];
        TileRenderer renderer(scene, geometry, rays, bodies, albedos, camera, tile);
        const std::vector<Pixel> rendered = renderer.render(costs[t]);
        for (int y = tile.y0; y < tile.y1; ++y)
            std::copy_n(
                rendered.begin() + std::ptrdiff_t(y - tile.y0) * tile.width(), tile.width(),
                pixels.begin() + std::ptrdiff_t(y - crop.y0) * crop.width() + (tile.x0 - crop.x0));
        progress.add(1);
    });
    progress.end();
    report(stats, costs, threads);
    return develop(camera, crop, pixels, options.layers);
}

}  // namespace tallow
