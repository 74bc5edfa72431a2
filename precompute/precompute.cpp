// SPDX-License-Identifier: Apache-2.0
// Pass one, in the order in which data flows: geometry -> samples -> octree -> direct irradiance ->
// indirect irradiance -> file.
#include "precompute/precompute.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "common/cloud/cache_io.h"
#include "common/cloud/scene_fingerprint.h"
#include "common/geometry/ray_scene.h"
#include "precompute/build_octree.h"
#include "precompute/choose_light_samples.h"
#include "precompute/earlier_cache.h"
#include "precompute/gather_indirect.h"
#include "precompute/gather_irradiance.h"
#include "precompute/sample_surface.h"
#include "precompute/tint_irradiance.h"

namespace tallow {
namespace {

struct IndirectGathering {
    int rays;
    std::optional<PatchSize> patches;  // without, rays are those of each sample
};

// Measured on figures, docs/INDIRECT.md: at a tolerance of 1 % the exitance is 0.8 to 1 % off with
// 256 rays from patches of four spacings radius, the most of it noise. Spacings follow the
// tolerance with the power 0.6, and noise the number of all paths with the power -0.57.
IndirectGathering indirect_gathering(const Settings& settings) {
    if (settings.indirect_samples) return {*settings.indirect_samples, std::nullopt};
    const double finer = 0.01 / std::max(double(settings.tolerance), 1e-4);
    return {std::clamp(int(std::lround(256 * std::pow(finer, 0.55))), 16, 65536),
            PatchSize{4, 0.3f}};
}

// Of the bunny; fewer where there are hollows.
constexpr double kSamplesPerPatch = 30;

// Samples whose direct light is gathered between two looks at the checkpoint. Chosen: some tenths
// of a second.
constexpr std::size_t kChunk = 1 << 18;
static_assert(kChunk % kGatherBlock == 0);

/// Takes bodies through the stages of pass one, each with the light that earlier runs left.
class BodySampler {
public:
    BodySampler(const Scene& scene, const SceneGeometry& geometry, const RayScene& rays,
                Progress& progress, Stats& stats)
        : scene_(scene), geometry_(geometry), rays_(rays), progress_(progress), stats_(stats) {}

    SampledBody sample(const BodySpacing& chosen) {
        const Surface& surface = geometry_.surfaces[chosen.object];
        SampledBody body{chosen.object, chosen.spacing, surface_area(surface), {}, {}, {}, {}};
        PhaseTimer sample_timer(stats_, "sample");
        body.samples = sample_surface(surface, body.spacing);
        progress_.note(fmt::format("{}: {} samples, {:.3g} mm apart, on {:.4g} mm^2",
                                   scene_.objects[body.object].where, body.samples.size(),
                                   body.spacing, body.area));
        sample_timer.stop();
        const PhaseTimer timer(stats_, "octree");
        body.nodes = build_octree(body.samples.position);
        return body;
    }

    /// `index` is the body's number in the checkpoint.
    void gather_direct(SampledBody& body, std::uint32_t index, const EarlierCache& earlier,
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
        const LightSampleCounts counts = light_sample_counts(body);
        progress_.begin("irradiance", count, "samples");
        for (std::size_t begin = 0; begin < count; begin += kChunk) {
            const std::size_t end = std::min(count, begin + kChunk);
            if (checkpoint.restore(Checkpoint::Stage::direct, index, begin, end, body.direct)) {
                progress_.add(end - begin);
                continue;
            }
            gather_irradiance_range(scene_, rays_, body.samples, eta, counts, {begin, end},
                                    body.direct, progress_);
            checkpoint.keep(Checkpoint::Stage::direct, index, begin, end, body.direct);
        }
        tint_irradiance(scene_, rays_, body.object, body.samples, body.direct);
        progress_.end();
    }

private:
    LightSampleCounts light_sample_counts(const SampledBody& body) {
        const std::optional<int> fixed = scene_.settings.light_samples;
        const LightSampleCounts counts =
            fixed ? equal_light_samples(scene_, *fixed)
                  : choose_light_samples(scene_, rays_, body.samples,
                                         subsurface(scene_, body.object)->medium,
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
    Progress& progress_;
    Stats& stats_;
    std::int64_t light_rays_ = 0;
};

/// Spacings as wished for; automatic ones give way to those of an earlier cache that are as good.
std::vector<BodySpacing> spacings_of(const ScenePlan& plan, const SceneGeometry& geometry,
                                     const SamplingWish& wish, const EarlierCache& earlier) {
    std::vector<BodySpacing> spacings = choose_spacings(plan.scene, geometry, plan.treatment, wish);
    if (!wish.spacing && !wish.samples)
        for (BodySpacing& body : spacings)
            body.spacing = earlier.spacing(body.object, body.spacing).value_or(body.spacing);
    return spacings;
}

Fingerprint with_spacings(Fingerprint fingerprint, const std::vector<BodySpacing>& spacings) {
    for (const BodySpacing& body : spacings)
        fingerprint.emplace_back(fmt::format("sampling.objects[{}].spacing_mm", body.object),
                                 fmt::format("{}", body.spacing));
    return fingerprint;
}

// Time of one sample, of one ray to a light and of one path of indirect light, on one thread.
// Measured on the bunny (docs/PLAN.md); within a factor of two elsewhere.
constexpr double kSecondsPerSample = 4e-7, kSecondsPerLightRay = 8e-8, kSecondsPerPath = 6e-7;
constexpr int kLikelyLightRays = 4;  // before the pilot has looked

void add_numbers(Plan& plan, const Scene& scene, const std::vector<BodySpacing>& spacings) {
    double samples = 0;
    for (const BodySpacing& body : spacings) {
        samples += body.expected;
        plan.numbers[fmt::format("objects[{}].spacing_mm", body.object)] = double(body.spacing);
        plan.numbers[fmt::format("objects[{}].samples", body.object)] = body.expected;
    }
    const double light_rays =
        double(scene.lights.size()) * scene.settings.light_samples.value_or(kLikelyLightRays);
    const IndirectGathering indirect = indirect_gathering(scene.settings);
    const double paths =
        double(indirect_bounces(scene)) * indirect.rays / (indirect.patches ? kSamplesPerPatch : 1);
    plan.numbers["samples"] = samples;
    plan.numbers["memory_bytes"] =
        memory_of_samples(samples, scene.groups.size(), indirect_bounces(scene) > 0);
    plan.numbers["predicted_seconds"] =
        samples * (kSecondsPerSample + light_rays * kSecondsPerLightRay + paths * kSecondsPerPath) /
        allowed_threads();
}

CacheView make_cache(const Scene& scene, const Fingerprint& fingerprint,
                     const std::vector<SampledBody>& bodies) {
    CacheView cache{fingerprint, {}, {}};
    for (const LightGroup& group : scene.groups) cache.groups.push_back(group.name);
    for (const SampledBody& body : bodies) cache.bodies.push_back(body.view());
    return cache;
}

std::filesystem::path checkpoint_file(std::filesystem::path cache_file) {
    return cache_file += ".part";
}

void report_diffusion(const Scene& scene, std::uint32_t object, const DiffusionReport& report,
                      Progress& progress, Stats& stats) {
    for (const Decision& decision : diffusion_decisions(object, report))
        stats.plan.decisions.push_back(decision);
    if (report.clusters == 0) return;
    stats.errors[fmt::format("objects[{}].diffusion", object)] = report.error;
    stats.errors[fmt::format("objects[{}].diffusion_converged", object)] =
        std::int64_t(report.converged);
    add_count(stats, "clusters", std::int64_t(report.clusters));
    const std::string warning =
        diffusion_warning(report, kPathsTolerance * double(scene.settings.tolerance));
    if (!warning.empty()) progress.note(scene.objects[object].where + ": " + warning);
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
    Fingerprint of_scene = scene_fingerprint(scene, geometry);
    // Numbers of rays follow from the tolerance, and light of two kinds must not mix.
    of_scene.emplace_back("sampling.tolerance", fmt::format("{}", scene.settings.tolerance));
    const EarlierCache earlier(cache_file, of_scene);

    PhaseTimer plan_timer(stats, "plan");
    ScenePlan planned = plan_scene(scene, geometry, double(scene.settings.tolerance));
    const auto spacings = spacings_of(planned, geometry, options.sampling, earlier);
    add_numbers(planned.plan, scene, spacings);
    stats.plan = planned.plan;
    plan_timer.stop();
    if (options.plan_only) return;
    for (const Decision& decision : planned.plan.decisions)
        if (!decision.computed) progress.note("left out: " + plan_text({{decision}, {}}));

    PhaseTimer bvh_timer(stats, "bvh");
    const RayScene rays(geometry.surfaces);
    bvh_timer.stop();
    const Fingerprint fingerprint = with_spacings(of_scene, spacings);
    Checkpoint checkpoint(checkpoint_file(cache_file), fingerprint, options.checkpoint);

    BodySampler sampler(scene, geometry, rays, progress, stats);
    std::vector<SampledBody> bodies;
    for (const BodySpacing& chosen : spacings) bodies.push_back(sampler.sample(chosen));
    try {
        for (std::uint32_t b = 0; b < bodies.size(); ++b)
            sampler.gather_direct(bodies[b], b, earlier, checkpoint);
        if (const int bounces = indirect_bounces(scene); bounces > 0 && !scene.lights.empty()) {
            const PhaseTimer timer(stats, "indirect");
            const IndirectGathering how = indirect_gathering(scene.settings);
            const auto reports =
                gather_indirect(scene, rays, bodies,
                                {bounces, how.rays, std::max(scene.settings.tolerance, 1e-3f),
                                 planned.diffuse, how.patches},
                                checkpoint, progress);
            for (std::size_t b = 0; b < bodies.size(); ++b)
                report_diffusion(scene, bodies[b].object, reports[b], progress, stats);
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
    const CacheView cache = make_cache(scene, fingerprint, bodies);
    write_cache(cache_file, cache);
    checkpoint.finish();
    write_timer.stop();
    count(cache, stats);
}

}  // namespace tallow
