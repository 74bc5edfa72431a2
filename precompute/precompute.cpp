// SPDX-License-Identifier: Apache-2.0
// Pass one, in the order in which data flows: geometry -> samples -> irradiance -> octree -> file.
#include "precompute/precompute.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/cloud/cache_io.h"
#include "common/cloud/scene_fingerprint.h"
#include "common/geometry/ray_scene.h"
#include "precompute/build_octree.h"
#include "precompute/earlier_cache.h"
#include "precompute/gather_indirect.h"
#include "precompute/sample_surface.h"
#include "precompute/tint_irradiance.h"

namespace tallow {
namespace {

// Peak memory of pass one for one sample of a body: cell, sample, sort keys, irradiance and
// direction of each group, tree. Measured on the bunny with two groups, as the growth of the peak
// from 663k to 2.65M samples: 106 bytes.
constexpr double kBytesPerSample = 150;

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

constexpr int kIndirectRays = 16;

// Samples whose direct light is gathered between two looks at the checkpoint. Chosen: some tenths
// of a second.
constexpr std::size_t kChunk = 1 << 18;
static_assert(kChunk % kGatherBlock == 0);

/// Takes one body after the other through the stages of pass one up to direct light.
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

    SampledBody sample(std::uint32_t object, const EarlierCache& earlier) {
        const Surface& surface = geometry_.surfaces[object];
        const Medium& medium = subsurface(scene_, object)->medium;
        SampledBody body{object, 0, surface_area(surface), {}, {}, {}, {}};
        const float wanted = options_.spacing.value_or(
            automatic_spacing(medium, scene_.settings.tolerance, surface_extent(surface)));
        body.spacing = options_.spacing ? wanted : earlier.spacing(object, wanted).value_or(wanted);
        sample_points(surface, body);
        const PhaseTimer timer(stats_, "octree");
        body.nodes = build_octree(body.samples.position);
        return body;
    }

    void gather_light(SampledBody& body, std::uint32_t index, const EarlierCache& earlier,
                      Checkpoint& checkpoint) {
        if (earlier.copy_direct_light(body)) {
            progress_.note(scene_.objects[body.object].where +
                           ": direct light kept from the earlier cache: only what reflects it has "
                           "changed");
            return;
        }
        const PhaseTimer timer(stats_, "irradiance");
        const float eta = subsurface(scene_, body.object)->medium.eta;
        const std::size_t count = body.samples.size();
        body.direct.assign(scene_.groups.size(),
                           {std::vector<Rgb>(count, Rgb(0)), std::vector<Vec3>(count, Vec3(0))});
        progress_.begin("irradiance", count, "samples");
        for (std::size_t begin = 0; begin < count; begin += kChunk) {
            const std::size_t end = std::min(count, begin + kChunk);
            if (checkpoint.restore(Checkpoint::Stage::direct, index, begin, end, body.direct)) {
                progress_.add(end - begin);
                continue;
            }
            gather_irradiance_range(scene_, rays_, body.samples, eta, begin, end, body.direct,
                                    progress_);
            checkpoint.keep(Checkpoint::Stage::direct, index, begin, end, body.direct);
        }
        tint_irradiance(scene_, rays_, body.object, body.samples, body.direct);
        progress_.end();
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

    const Scene& scene_;
    const SceneGeometry& geometry_;
    const RayScene& rays_;
    const PrecomputeOptions& options_;
    Progress& progress_;
    Stats& stats_;
};

Fingerprint with_spacings(Fingerprint fingerprint, const std::vector<SampledBody>& bodies) {
    for (const SampledBody& body : bodies)
        fingerprint.emplace_back(fmt::format("sampling.objects[{}].spacing_mm", body.object),
                                 fmt::format("{}", body.spacing));
    return fingerprint;
}

CacheView make_cache(const Scene& scene, Fingerprint fingerprint,
                     const std::vector<SampledBody>& bodies) {
    CacheView cache;
    cache.fingerprint = std::move(fingerprint);
    for (const LightGroup& group : scene.groups) cache.groups.push_back(group.name);
    for (const SampledBody& body : bodies) cache.bodies.push_back(body.view());
    return cache;
}

std::filesystem::path checkpoint_file(std::filesystem::path cache_file) {
    return cache_file += ".part";
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

    const Fingerprint fingerprint = scene_fingerprint(scene, geometry);
    const EarlierCache earlier(cache_file, fingerprint);
    BodySampler sampler(scene, geometry, rays, options, progress, stats);
    std::vector<SampledBody> bodies;
    for (std::uint32_t object = 0; object < scene.objects.size(); ++object)
        if (subsurface(scene, object) != nullptr) bodies.push_back(sampler.sample(object, earlier));

    const Fingerprint sampled = with_spacings(fingerprint, bodies);
    Checkpoint checkpoint(checkpoint_file(cache_file), sampled, options.checkpoint);
    try {
        for (std::uint32_t b = 0; b < bodies.size(); ++b)
            sampler.gather_light(bodies[b], b, earlier, checkpoint);
        if (const int bounces = indirect_bounces(scene); bounces > 0 && !scene.lights.empty()) {
            const PhaseTimer timer(stats, "indirect");
            gather_indirect(scene, rays, bodies,
                            {bounces, kIndirectRays, std::max(scene.settings.tolerance, 1e-3f)},
                            checkpoint, progress);
        }
    } catch (const Interrupted&) {
        checkpoint.write_pending();
        progress.note(fmt::format("what is done is kept in {}; go on with --resume",
                                  checkpoint.file().string()));
        throw;
    }
    if (options.checkpoint.resume)
        progress.note(fmt::format("{} sample results came from {}", checkpoint.restored_samples(),
                                  checkpoint.file().string()));

    PhaseTimer write_timer(stats, "write");
    const CacheView cache = make_cache(scene, sampled, bodies);
    write_cache(cache_file, cache);
    checkpoint.finish();
    write_timer.stop();
    count(cache, stats);
}

}  // namespace tallow
