// SPDX-License-Identifier: Apache-2.0
#include "experiments/evaluator/problem.h"

#include <fmt/format.h>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "common/cloud/cache_io.h"
#include "common/cloud/scene_fingerprint.h"
#include "common/scene/presets.h"
#include "common/scene/scene_geometry.h"
#include "common/scene/scene_yaml.h"
#include "render/primary_hits.h"

namespace tallow {
namespace {

constexpr int kTileSize = 32;  // as in render/band_renderer.cpp

bool same(Rgb a, Rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

// A material keeps the name that the scene gave it whatever preset --set puts there.
std::string material_name(const Material& material, const Medium& medium) {
    for (const Preset& preset : presets())
        if (same(preset.medium.sigma_a, medium.sigma_a) &&
            same(preset.medium.sigma_s_prime, medium.sigma_s_prime))
            return preset.name;
    return material.name;
}

std::vector<Tile> cut_into_tiles(const Camera& camera) {
    std::vector<Tile> tiles;
    for (int y = 0; y < camera.height; y += kTileSize)
        for (int x = 0; x < camera.width; x += kTileSize)
            tiles.push_back({x, y, std::min(x + kTileSize, camera.width),
                             std::min(y + kTileSize, camera.height)});
    return tiles;
}

std::vector<Vec3> find_points(const Scene& scene, const SceneGeometry& geometry,
                              std::uint32_t object, int samples) {
    const RayScene rays(geometry.surfaces);
    const Camera& camera = scene.cameras.front();
    require_camera_outside(scene, rays, camera);
    const std::vector<Tile> tiles = cut_into_tiles(camera);
    std::vector<std::vector<Vec3>> of_tile(tiles.size());
    parallel_for(tiles.size(), 1, [&](std::size_t i) {
        const PrimaryHits hits =
            find_primary_hits(scene, rays, camera, tiles[i], {0, samples, samples});
        for (const ShadingPoint& point : hits.points)
            if (point.depth == 0 && point.hit.object == object)
                of_tile[i].push_back(point.hit.position);
    });
    std::vector<Vec3> points;
    for (const std::vector<Vec3>& some : of_tile)
        points.insert(points.end(), some.begin(), some.end());
    return points;
}

}  // namespace

Problem load_problem(const std::filesystem::path& scene_file,
                     const std::filesystem::path& cache_file,
                     const std::vector<std::string>& overrides, int samples, Stats& stats) {
    const Scene scene = load_scene(scene_file, overrides);
    const SceneGeometry geometry = load_geometry(scene, stats);
    const MappedCache cache(cache_file);
    require_fingerprint(cache_file, cache.view().fingerprint, scene_fingerprint(scene, geometry));
    if (cache.view().bodies.size() != 1)
        throw InputError(fmt::format("{}: expected one translucent body, got {}",
                                     cache_file.string(), cache.view().bodies.size()));
    const BodyView& body = cache.view().bodies.front();
    const SubsurfaceMaterial& kind = *subsurface(scene, body.object);

    Problem problem{
        scene_file.stem().string(),
        material_name(scene.materials[scene.objects[body.object].material], kind.medium),
        kind,
        kind.single_scattering == Switch::off ? Orders::all : Orders::two_and_more,
        light_samples(body, scene.groups),
        {},
        find_points(scene, geometry, body.object, samples)};
    if (problem.points.empty())
        throw InputError(fmt::format("{}: the camera does not see the body", scene_file.string()));
    for (int c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < problem.samples.position.size(); ++i)
            problem.flux[std::size_t(c)].push_back(problem.samples.E_t[i][c] *
                                                   problem.samples.area[i]);
    return problem;
}

std::unique_ptr<Profile> profile(const Problem& problem, int channel) {
    return make_profile(problem.kind.model, problem.kind.medium, channel, problem.orders);
}

}  // namespace tallow
