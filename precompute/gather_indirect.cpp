// SPDX-License-Identifier: Apache-2.0
// Samples -> indirect irradiance, in rounds: the exitance of all bodies under the light known so
// far, then one set of paths from every patch of them. The paths are the same in each round, so
// that what opaque surfaces send is collected in the first round only.
#include "precompute/gather_indirect.h"

#include <algorithm>
#include <memory>
#include <numbers>

#include "common/exitance/body_exitance.h"
#include "common/lighting/flights.h"
#include "precompute/body_paths.h"
#include "precompute/gather_patches.h"
#include "precompute/tint_irradiance.h"

namespace tallow {
namespace {

// Rays that are followed before exitance is asked for at all the places that they met. Chosen: the
// evaluator has neighbours enough, and a round's memory stays near 100 MB.
constexpr std::size_t kRaysPerChunk = 1 << 19;

// Places on bodies that are kept from round to round, of all bodies: 240 MB. Chosen: enough for
// ten figures at a tolerance of 1 %. What does not fit is followed again.
constexpr std::size_t kMostKept = 1 << 22;

GroupFields make_fields(const Scene& scene, const BodyView& body, const BodyExitance& exitance,
                        float tolerance, DiffusionReport& worst) {
    GroupFields fields;
    for (std::size_t g = 0; g < scene.groups.size(); ++g) {
        std::vector<LightGroup> only(scene.groups.size(), {"", Rgb(0)});
        only[g].scale = Rgb(1);
        const LitSamples lit = light_samples(body, only);
        if (lit.position.empty()) {
            fields.push_back(nullptr);
            continue;
        }
        const BodyDiffusion::Solution solution = exitance.solve(lit);
        add_worse(worst, exitance.report(solution));
        fields.push_back(std::make_unique<ExitanceField>(
            exitance.field(lit, solution, ExitanceAccuracy{float(kPathsTolerance) * tolerance})));
    }
    return fields;
}

// `a` becomes the sum of both.
void add(std::vector<GroupIrradiance>& a, const std::vector<GroupIrradiance>& b) {
    for (std::size_t g = 0; g < a.size(); ++g)
        for (std::size_t i = 0; i < a[g].E_t.size(); ++i)
            a[g].E_t[i] += b[g].E_t[i], a[g].w_i[i] += b[g].w_i[i];
}

void clear(std::vector<GroupIrradiance>& groups, std::size_t begin, std::size_t end) {
    for (GroupIrradiance& group : groups) {
        std::fill(&group.E_t[begin], &group.E_t[begin] + (end - begin), Rgb(0));
        std::fill(&group.w_i[begin], &group.w_i[begin] + (end - begin), Vec3(0));
    }
}

GatherPatches make_patches(const RayScene& rays, const SampledBody& body, const PatchTree* tree,
                           const std::optional<PatchSize>& size) {
    const SurfaceSamples& samples = body.samples;
    if (!size) return GatherPatches(samples);
    if (tree) return {samples, rays, *tree, body.spacing, *size};
    const double radius = double(body.spacing * size->largest_radius);
    return {samples, rays,
            build_patch_tree({samples.position, samples.normal, samples.area},
                             std::numbers::pi * radius * radius),
            body.spacing, *size};
}

/// What reaches one body, chunk by chunk of its patches; chunks that the checkpoint has are not
/// gathered again.
class BodyReceiver {
public:
    BodyReceiver(const Scene& scene, const RayScene& rays, const SampledBody& body,
                 const PatchTree* tree, const IndirectOptions& options, std::size_t most_kept)
        : patches_(make_patches(rays, body, tree, options.patches)),
          paths_(scene, rays, body, patches_, {options.bounces, options.rays, options.diffuse},
                 options.bounces > 1 ? most_kept : 0),
          chunk_(std::max<std::size_t>(64, kRaysPerChunk / std::size_t(options.rays))),
          by_surfaces_(scene.groups.size(),
                       {std::vector<Rgb>(patches_.count()), std::vector<Vec3>(patches_.count())}),
          by_bodies_(by_surfaces_) {}

    std::size_t count() const { return patches_.count(); }

    void gather(int round, std::uint32_t body, const std::vector<GroupFields>& fields,
                Checkpoint& checkpoint, Progress& progress) {
        for (std::size_t begin = 0; begin < count(); begin += chunk_) {
            const std::size_t end = std::min(count(), begin + chunk_);
            const Part part{round, body, begin, end};
            if (!restore(part, checkpoint)) gather(part, fields, checkpoint);
            progress.add(end - begin);
        }
    }

    std::vector<GroupIrradiance> on_samples() const {
        std::vector<GroupIrradiance> sums = by_bodies_;
        add(sums, by_surfaces_);
        return patches_.spread(std::move(sums));
    }

private:
    struct Part {
        int round;
        std::uint32_t body;
        std::size_t begin, end;
        Checkpoint::Stage stage() const {
            return Checkpoint::Stage(std::uint32_t(Checkpoint::Stage::bodies) +
                                     std::uint32_t(round));
        }
    };

    bool restore(const Part& part, Checkpoint& checkpoint) {
        return (part.round > 0 || checkpoint.restore(Checkpoint::Stage::surfaces, part.body,
                                                     part.begin, part.end, by_surfaces_)) &&
               checkpoint.restore(part.stage(), part.body, part.begin, part.end, by_bodies_);
    }

    void gather(const Part& part, const std::vector<GroupFields>& fields, Checkpoint& checkpoint) {
        if (part.round == 0) clear(by_surfaces_, part.begin, part.end);
        clear(by_bodies_, part.begin, part.end);
        paths_.gather(part.begin, part.end, fields, part.round == 0 ? &by_surfaces_ : nullptr,
                      by_bodies_);
        if (part.round == 0)
            checkpoint.keep(Checkpoint::Stage::surfaces, part.body, part.begin, part.end,
                            by_surfaces_);
        checkpoint.keep(part.stage(), part.body, part.begin, part.end, by_bodies_);
    }

    GatherPatches patches_;
    BodyPaths paths_;
    std::size_t chunk_;
    std::vector<GroupIrradiance> by_surfaces_, by_bodies_;  // [group][patch]
};

}  // namespace

std::vector<DiffusionReport> gather_indirect(const Scene& scene, const RayScene& rays,
                                             std::vector<SampledBody>& bodies,
                                             const IndirectOptions& options, Checkpoint& checkpoint,
                                             Progress& progress) {
    std::vector<BodyView> views;          // [body] without indirect light
    std::vector<BodyExitance> exitance;   // [body]
    std::vector<BodyReceiver> receivers;  // [body]
    views.reserve(bodies.size()), receivers.reserve(bodies.size());
    std::vector<DiffusionReport> worst(bodies.size());
    std::size_t patches = 0;
    for (SampledBody& body : bodies) {
        views.push_back(body.view());
        exitance.emplace_back(
            views.back(), scene, Orders::all, ExitanceUse::paths,
            flights_in(rays, body.object, subsurface(scene, body.object)->medium.eta),
            DiffusionWish{kPathsTolerance * double(options.tolerance)});
        receivers.emplace_back(scene, rays, body, exitance.back().tree(), options,
                               kMostKept / bodies.size());
        patches += receivers.back().count();
    }
    progress.begin("indirect", patches * std::size_t(options.bounces), "places");
    for (int round = 0; round < options.bounces; ++round) {
        std::vector<GroupFields> fields(scene.objects.size());
        for (std::size_t b = 0; b < bodies.size(); ++b)
            fields[bodies[b].object] =
                make_fields(scene, bodies[b].view(), exitance[b], options.tolerance, worst[b]);
        for (SampledBody& body : bodies) body.indirect = {};  // the fields have it
        for (std::size_t b = 0; b < bodies.size(); ++b)
            receivers[b].gather(round, std::uint32_t(b), fields, checkpoint, progress);
        // Only now: all bodies were to see the same light.
        for (std::size_t b = 0; b < bodies.size(); ++b) {
            bodies[b].indirect = receivers[b].on_samples();
            tint_irradiance(scene, rays, bodies[b].object, bodies[b].samples, bodies[b].indirect);
        }
    }
    progress.end();
    return worst;
}

}  // namespace tallow
