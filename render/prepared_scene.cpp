// SPDX-License-Identifier: Apache-2.0
// Scene, geometry and cache -> all that does not depend on the camera.
#include "render/prepared_scene.h"

#include <algorithm>

#include "common/exitance/body_exitance.h"
#include "common/lighting/beam_lengths.h"
#include "render/march_steps.h"

namespace tallow {
namespace {

// What single scattering does not add, the exitance must hold.
Orders orders_of_exitance(const SubsurfaceMaterial& material) {
    return material.single_scattering == Switch::off ? Orders::all : Orders::two_and_more;
}

// Lights whose group has the scale 0 get no rays.
Scene without_dark_lights(Scene scene) {
    for (Light& light : scene.lights) light.off = max_channel(scene.groups[light.group].scale) == 0;
    return scene;
}

bool has_opaque_surface(const Scene& scene, const std::vector<std::optional<Rgb>>& diffuse) {
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        if (subsurface(scene, i) == nullptr || (!diffuse.empty() && diffuse[i])) return true;
    return false;
}

RayScene build_rays(const SceneGeometry& geometry, Stats& stats) {
    const PhaseTimer timer(stats, "bvh");
    return RayScene(geometry.surfaces);
}

}  // namespace

PreparedScene::PreparedScene(Scene scene, const SceneGeometry& geometry, CacheView cache,
                             ExitanceAccuracy accuracy,
                             const std::vector<std::optional<Rgb>>& diffuse, Stats& stats)
    : geometry_(geometry),
      cache_(std::move(cache)),
      accuracy_(accuracy),
      rays_(build_rays(geometry, stats)),
      scene_(std::move(scene)),
      lit_(without_dark_lights(scene_)),
      bodies_(scene_.objects.size()) {
    prepare_bodies(stats);
    for (const Material& material : scene_.materials) albedos_.push_back(albedo(material));
    const int bounces = indirect_bounces(scene_);
    reflected_.emplace(lit_, rays_, bounces, diffuse);
    indirect_ = bounces > 0 && has_opaque_surface(scene_, diffuse);
}

void PreparedScene::prepare_bodies(Stats& stats) {
    const PhaseTimer timer(stats, "octree");
    std::int64_t samples = 0, lit = 0, clusters = 0;
    for (const BodyView& view : cache_.bodies) {
        const SubsurfaceMaterial& material = *subsurface(scene_, view.object);
        const LitSamples lit_samples = light_samples(
            view, scene_.groups, indirect_bounces(scene_) > 0 ? indirect_gain(material) : Rgb(0));
        samples += std::int64_t(view.positions.size());
        lit += std::int64_t(lit_samples.position.size());
        const BodyExitance exitance(view, scene_, orders_of_exitance(material), ExitanceUse::seen);
        BodyExitance::Report solved;
        const auto beams = beam_lengths(rays_, view.object, lit_samples, exitance.beam_length());
        bodies_[view.object].emplace(
            PreparedBody{&material, surface_factors(material),
                         exitance.field(lit_samples, beams, accuracy_, &solved),
                         march_steps_of_pixel(material.model, material.medium, accuracy_.tolerance),
                         std::nullopt});
        clusters += std::int64_t(solved.clusters);
        if (material.connection == Connection::exact)
            bodies_[view.object]->connections.emplace(geometry_.surfaces[view.object],
                                                      material.medium.eta);
    }
    stats.counts["samples"] = samples;
    stats.counts["lit_samples"] = lit;
    if (clusters > 0) stats.counts["clusters"] = clusters;
}

}  // namespace tallow
