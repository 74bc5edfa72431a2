// SPDX-License-Identifier: Apache-2.0
// Pass one, in the order in which data flows: geometry -> samples -> irradiance -> octree -> file.
#include "precompute/precompute.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/cloud/cache_io.h"
#include "common/cloud/scene_fingerprint.h"
#include "common/geometry/ray_scene.h"
#include "precompute/build_octree.h"
#include "precompute/choose_light_samples.h"
#include "precompute/gather_irradiance.h"
#include "precompute/sample_surface.h"

namespace tallow {
namespace {

// Peak memory of pass one for one sample of a body: cell, sample, sort keys, irradiance and
// direction of each group, tree. Measured on the bunny with two groups, as the growth of the peak
// from 663k to 2.65M samples: 106 bytes.
constexpr double kBytesPerSample = 150;

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

float surface_extent(const Surface& surface) {
    if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) {
        Vec3 low(kInfinity), high(-kInfinity);
        for (Vec3 v : mesh->vertices) low = glm::min(low, v), high = glm::max(high, v);
        return glm::length(high - low);
    }
    if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
        float extent = 0;
        for (int i = 0; i < 3; ++i)
            extent = std::max(extent, 2 * glm::length(sphere->to_world.linear[i]));
        return extent;
    }
    if (const auto* plane = std::get_if<PlaneSurface>(&surface)) return 2 * plane->radius;
    return kInfinity;
}

void require_memory(const std::string& where, double samples, float spacing) {
    const double available = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGE_SIZE));
    const double needed = samples * kBytesPerSample;
    if (needed < 0.8 * available && samples < 4e9) return;
    throw InputError(fmt::format(
        "{}: a spacing of {:.3g} mm takes about {:.3g} samples and {:.1f} GiB, more than this "
        "machine's memory of {:.1f} GiB allows; give a larger --spacing",
        where, spacing, samples, needed / (1 << 30), available / (1 << 30)));
}

/// Takes one body after the other through the stages of pass one.
class BodySampler {
public:
    BodySampler(const Scene& scene, const SceneGeometry& geometry, const RayScene& rays,
                const PrecomputeOptions& options, Progress& progress, Stats& stats)
        : scene_(scene),
          geometry_(geometry),
          rays_(rays),
          options_(options),
          progress_(progress),
          stats_(stats) {}

    SampledBody sample(std::uint32_t object) {
        const Surface& surface = geometry_.surfaces[object];
        const Medium& medium = subsurface(scene_, object)->medium;
        SampledBody body{object, 0, surface_area(surface), {}, {}, {}};
        body.spacing = options_.spacing.value_or(
            automatic_spacing(medium, scene_.settings.tolerance, surface_extent(surface)));
        sample_points(surface, body);
        gather_light(medium, body);
        const PhaseTimer timer(stats_, "octree");
        body.nodes = build_octree(body.samples.position);
        return body;
    }

private:
    void sample_points(const Surface& surface, SampledBody& body) {
        const std::string& where = scene_.objects[body.object].where;
        require_memory(where, body.area / (body.spacing * body.spacing), body.spacing);
        const PhaseTimer timer(stats_, "sample");
        body.samples = sample_surface(surface, body.spacing);
        progress_.note(fmt::format("{}: {} samples, {:.3g} mm apart, on {:.4g} mm^2", where,
                                   body.samples.size(), body.spacing, body.area));
    }

    void gather_light(const Medium& medium, SampledBody& body) {
        const PhaseTimer timer(stats_, "irradiance");
        progress_.begin("irradiance", body.samples.size(), "samples");
        const LightSampleCounts counts = light_sample_counts(medium, body);
        body.groups = gather_irradiance(scene_, rays_, body.samples, medium.eta, counts, progress_);
        progress_.end();
    }

    LightSampleCounts light_sample_counts(const Medium& medium, const SampledBody& body) {
        const std::optional<int> fixed = scene_.settings.light_samples;
        const LightSampleCounts counts =
            fixed ? equal_light_samples(scene_, *fixed)
                  : choose_light_samples(scene_, rays_, body.samples, medium,
                                         scene_.settings.tolerance);
        if (!fixed)
            progress_.note(fmt::format("{}: rays of each sample to the lights: {}",
                                       scene_.objects[body.object].where, fmt::join(counts, ", ")));
        for (const int count : counts) light_rays_ += count * std::int64_t(body.samples.size());
        stats_.counts["light_rays"] = light_rays_;
        return counts;
    }

    const Scene& scene_;
    const SceneGeometry& geometry_;
    const RayScene& rays_;
    const PrecomputeOptions& options_;
    Progress& progress_;
    Stats& stats_;
    std::int64_t light_rays_ = 0;
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

float automatic_spacing(const Medium& medium, double tolerance, float extent) {
    // At zero tolerance as at 0.01 %: the sampling of a surface is never exact.
    const double scale = std::sqrt(std::max(tolerance, 1e-4) / 0.01);
    return std::min(float(0.35 * scale * double(min_channel(medium.mean_free_path()))), extent / 5);
}

void precompute(const Scene& scene, const PrecomputeOptions& options,
                const std::filesystem::path& cache_file, Progress& progress, Stats& stats) {
    const SceneGeometry geometry = load_geometry(scene, stats);
    for (const std::string& report : geometry.repair_reports) progress.note(report);

    PhaseTimer bvh_timer(stats, "bvh");
    const RayScene rays(geometry.surfaces);
    bvh_timer.stop();

    BodySampler sampler(scene, geometry, rays, options, progress, stats);
    std::vector<SampledBody> bodies;
    for (std::uint32_t object = 0; object < scene.objects.size(); ++object)
        if (subsurface(scene, object) != nullptr) bodies.push_back(sampler.sample(object));

    PhaseTimer write_timer(stats, "write");
    const CacheView cache = make_cache(scene, geometry, bodies);
    write_cache(cache_file, cache);
    write_timer.stop();
    count(cache, stats);
}

}  // namespace tallow
