// SPDX-License-Identifier: Apache-2.0
// Pass one, in the order in which data flows: geometry -> samples -> irradiance -> octree -> file.
#include "precompute/precompute.h"

#include <fmt/format.h>
#include "common/cloud/cache_io.h"
#include "common/cloud/scene_fingerprint.h"
#include "common/geometry/ray_scene.h"
#include "precompute/build_octree.h"
#include "precompute/gather_irradiance.h"
#include "precompute/sample_surface.h"

namespace tallow {
namespace {

/// What is computed for one body; owns what its BodyView points to.
struct SampledBody {
    std::uint32_t object;
    float spacing;
    double area;
    SurfaceSamples samples;
    std::vector<GroupIrradiance> groups;
    std::vector<OctreeNode> nodes;

    BodyView view() const {
        BodyView view{object,         spacing,      area,  samples.position,
                      samples.normal, samples.area, nodes, {}};
        for (const GroupIrradiance& group : groups) view.groups.push_back({group.E_t, group.w_i});
        return view;
    }
};

/// Takes one body after the other through the stages of pass one.
class BodySampler {
public:
    BodySampler(const Scene& scene, const SceneGeometry& geometry, const RayScene& rays,
                Progress& progress, Stats& stats)
        : scene_(scene), geometry_(geometry), rays_(rays), progress_(progress), stats_(stats) {}

    SampledBody sample(const BodySpacing& chosen) {
        const Surface& surface = geometry_.surfaces[chosen.object];
        const Medium& medium = subsurface(scene_, chosen.object)->medium;
        SampledBody body{chosen.object, chosen.spacing, surface_area(surface), {}, {}, {}};
        sample_points(surface, body);
        gather_light(medium, body);
        const PhaseTimer timer(stats_, "octree");
        body.nodes = build_octree(body.samples.position);
        return body;
    }

private:
    void sample_points(const Surface& surface, SampledBody& body) {
        const std::string& where = scene_.objects[body.object].where;
        const PhaseTimer timer(stats_, "sample");
        body.samples = sample_surface(surface, body.spacing);
        progress_.note(fmt::format("{}: {} samples, {:.3g} mm apart, on {:.4g} mm^2", where,
                                   body.samples.size(), body.spacing, body.area));
    }

    void gather_light(const Medium& medium, SampledBody& body) {
        const PhaseTimer timer(stats_, "irradiance");
        progress_.begin("irradiance", body.samples.size(), "samples");
        body.groups = gather_irradiance(scene_, rays_, body.samples, medium.eta, progress_);
        progress_.end();
    }

    const Scene& scene_;
    const SceneGeometry& geometry_;
    const RayScene& rays_;
    Progress& progress_;
    Stats& stats_;
};

CacheView make_cache(const Scene& scene, const SceneGeometry& geometry,
                     const std::vector<SampledBody>& bodies) {
    CacheView cache;
    cache.fingerprint = scene_fingerprint(scene, geometry);
    for (const LightGroup& group : scene.groups) cache.groups.push_back(group.name);
    for (const SampledBody& body : bodies) {
        cache.fingerprint.emplace_back(fmt::format("sampling.objects[{}].spacing_mm", body.object),
                                       fmt::format("{}", body.spacing));
        cache.bodies.push_back(body.view());
    }
    return cache;
}

void count(const CacheView& cache, Stats& stats) {
    std::int64_t samples = 0, nodes = 0;
    for (const BodyView& body : cache.bodies) {
        samples += std::int64_t(body.positions.size());
        nodes += std::int64_t(body.nodes.size());
    }
    stats.counts["bodies"] = std::int64_t(cache.bodies.size());
    stats.counts["samples"] = samples;
    stats.counts["nodes"] = nodes;
}

}  // namespace

void precompute(const Scene& scene, const PrecomputeOptions& options,
                const std::filesystem::path& cache_file, Progress& progress, Stats& stats) {
    const SceneGeometry geometry = load_geometry(scene, stats);
    for (const std::string& report : geometry.repair_reports) progress.note(report);

    PhaseTimer bvh_timer(stats, "bvh");
    const RayScene rays(geometry.surfaces);
    bvh_timer.stop();

    PhaseTimer spacing_timer(stats, "spacing");
    const std::vector<BodySpacing> spacings = choose_spacings(scene, geometry, options.sampling);
    spacing_timer.stop();
    BodySampler sampler(scene, geometry, rays, progress, stats);
    std::vector<SampledBody> bodies;
    for (const BodySpacing& chosen : spacings) bodies.push_back(sampler.sample(chosen));

    PhaseTimer write_timer(stats, "write");
    const CacheView cache = make_cache(scene, geometry, bodies);
    write_cache(cache_file, cache);
    write_timer.stop();
    count(cache, stats);
}

}  // namespace tallow
