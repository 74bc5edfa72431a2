// SPDX-License-Identifier: Apache-2.0
// Samples -> indirect irradiance, in rounds: the exitance of all bodies under the light known so
// far, then one set of paths from every sample. The paths are the same in each round, so that what
// opaque surfaces send is collected in the first round only.
#include "precompute/gather_indirect.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "common/exitance/body_exitance.h"
#include "common/lighting/cosine_direction.h"
#include "common/lighting/flights.h"
#include "common/lighting/light_paths.h"
#include "common/optics/fresnel.h"
#include "precompute/tint_irradiance.h"

namespace tallow {
namespace {

// Rays that are followed before exitance is asked for at all the places that they met. Chosen: the
// evaluator has neighbours enough, and a round's memory stays near 100 MB.
constexpr std::size_t kRaysPerChunk = 1 << 19;
constexpr std::size_t kBlock = 64;  // samples of a task

/// A body's exitance under each light group alone.
using GroupFields = std::vector<std::unique_ptr<ExitanceField>>;

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
            exitance.field(lit, solution, ExitanceAccuracy{tolerance})));
    }
    return fields;
}

/// Where a sample's ray sets out, and how its radiance counts.
struct StartOfPath {
    Vec3 w;
    float weight;  // pi F_t / rays, 0 if nothing enters along it
    Vec3 w_refracted;
};

/// One round of paths from the samples of one body.
class Round {
public:
    Round(const Scene& scene, const RayScene& rays, const std::vector<GroupFields>& fields,
          const IndirectOptions& options, SampledBody& body, LightPaths::Collect collect,
          std::vector<GroupIrradiance>& by_surfaces, std::vector<GroupIrradiance>& by_bodies)
        : rays_(rays),
          fields_(fields),
          options_(options),
          body_(body),
          paths_(scene, rays, options.bounces, options.diffuse),
          eta_(subsurface(scene, body.object)->medium.eta),
          groups_(scene.groups.size()),
          collect_(collect),
          by_surfaces_(by_surfaces),
          by_bodies_(by_bodies) {}

    void gather(std::size_t begin, std::size_t end) {
        const std::size_t blocks = (end - begin + kBlock - 1) / kBlock;
        std::vector<std::vector<BodyVertex>> vertices(blocks);
        parallel_for(blocks, 1, [&](std::size_t b) {
            const std::size_t first = begin + b * kBlock;
            vertices[b] = follow_paths(first, std::min(end, first + kBlock));
        });
        for (std::uint32_t object = 0; object < fields_.size(); ++object)
            if (!fields_[object].empty()) add_exitance(object, vertices);
    }

private:
    StartOfPath start(std::size_t sample, std::size_t ray) const {
        const auto index = std::uint32_t(sample * std::size_t(options_.rays) + ray);
        const Vec2 u = sobol_2d(index, body_.object + 1);
        const Vec3 n = body_.samples.normal[sample];
        const Vec3 w = cosine_direction(n, u);
        const float cos_i = std::min(1.0f, glm::dot(w, n));
        const auto w_refracted = refract(w, n, eta_);
        if (!w_refracted || !(cos_i > 0)) return {w, 0, {}};
        return {w, kPi * fresnel_transmittance(eta_, cos_i) / float(options_.rays), *w_refracted};
    }

    // Receivers are numbered sample * rays + ray.
    std::vector<BodyVertex> follow_paths(std::size_t begin, std::size_t end) {
        std::vector<BodyVertex> vertices;
        std::vector<Rgb> L(groups_);
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t k = 0; k < std::size_t(options_.rays); ++k) {
                const StartOfPath path = start(i, k);
                if (path.weight == 0) continue;
                std::fill(L.begin(), L.end(), Rgb(0));
                const auto receiver = std::uint32_t(i * std::size_t(options_.rays) + k);
                const Vec3 n = body_.samples.normal[i];
                paths_.follow({rays_.offset_origin(body_.samples.ray_origin[i], n, n), path.w},
                              receiver, mix_bits(receiver + (std::uint64_t(body_.object) << 40)),
                              collect_, L, vertices);
                if (collect_ == LightPaths::Collect::bodies) continue;
                for (std::size_t g = 0; g < groups_; ++g) add(by_surfaces_[g], i, path, L[g]);
            }
        return vertices;
    }

    void add_exitance(std::uint32_t object, std::span<const std::vector<BodyVertex>> vertices) {
        std::vector<ExitancePoint> points;
        std::vector<std::size_t> first;  // [block]
        for (const auto& block : vertices) {
            first.push_back(points.size());
            for (const BodyVertex& v : block)
                if (v.object == object) points.push_back({v.position, v.n, v.w_o});
        }
        if (points.empty()) return;
        for (std::size_t g = 0; g < groups_; ++g) {
            if (!fields_[object][g]) continue;
            const Exitance exitance = fields_[object][g]->gather(points);
            parallel_for(vertices.size(), 1, [&](std::size_t b) {
                std::size_t next = first[b];
                for (const BodyVertex& v : vertices[b]) {
                    if (v.object != object) continue;
                    const std::size_t rays = std::size_t(options_.rays);
                    const StartOfPath path = start(v.receiver / rays, v.receiver % rays);
                    add(by_bodies_[g], v.receiver / rays, path, v.factor * exitance.M[next++]);
                }
            });
        }
    }

    static void add(GroupIrradiance& group, std::size_t sample, const StartOfPath& path, Rgb L) {
        const Rgb E_t = path.weight * L;
        group.E_t[sample] += E_t;
        group.w_i[sample] += mean(E_t) * path.w_refracted;  // divided by their sum at the end
    }

    const RayScene& rays_;
    const std::vector<GroupFields>& fields_;  // [object], empty for opaque ones
    const IndirectOptions& options_;
    SampledBody& body_;
    LightPaths paths_;
    float eta_;
    std::size_t groups_;
    LightPaths::Collect collect_;
    std::vector<GroupIrradiance>&by_surfaces_, &by_bodies_;
};

std::vector<GroupIrradiance> dark(std::size_t groups, std::size_t samples) {
    return std::vector<GroupIrradiance>(
        groups, {std::vector<Rgb>(samples, Rgb(0)), std::vector<Vec3>(samples, Vec3(0))});
}

// `a` becomes the sum of both, sums of directions become means.
void add(std::vector<GroupIrradiance>& a, const std::vector<GroupIrradiance>& b) {
    for (std::size_t g = 0; g < a.size(); ++g)
        parallel_for(a[g].E_t.size(), 8192, [&](std::size_t i) {
            Rgb& E_t = a[g].E_t[i];
            E_t += b[g].E_t[i];
            const Vec3 w = a[g].w_i[i] + b[g].w_i[i];
            a[g].w_i[i] = mean(E_t) > 0 ? w / std::max(mean(E_t), glm::length(w)) : Vec3(0);
        });
}

/// What surfaces and what bodies send to the samples of one body.
struct Contributions {
    std::vector<GroupIrradiance> by_surfaces, by_bodies;
};

void clear(std::vector<GroupIrradiance>& groups, std::size_t begin, std::size_t end) {
    for (GroupIrradiance& group : groups) {
        std::fill(&group.E_t[begin], &group.E_t[begin] + (end - begin), Rgb(0));
        std::fill(&group.w_i[begin], &group.w_i[begin] + (end - begin), Vec3(0));
    }
}

/// The work for one body in one round: chunks that the checkpoint has not.
class BodyRound {
public:
    BodyRound(Round& paths, Checkpoint& checkpoint, int round, std::uint32_t body, Contributions& c)
        : paths_(paths), checkpoint_(checkpoint), round_(round), body_(body), c_(c) {}

    void gather(std::size_t begin, std::size_t end) {
        if (restore(begin, end)) return;
        if (round_ == 0) clear(c_.by_surfaces, begin, end);
        clear(c_.by_bodies, begin, end);
        paths_.gather(begin, end);
        if (round_ == 0)
            checkpoint_.keep(Checkpoint::Stage::surfaces, body_, begin, end, c_.by_surfaces);
        checkpoint_.keep(stage(), body_, begin, end, c_.by_bodies);
    }

private:
    bool restore(std::size_t begin, std::size_t end) {
        return (round_ > 0 || checkpoint_.restore(Checkpoint::Stage::surfaces, body_, begin, end,
                                                  c_.by_surfaces)) &&
               checkpoint_.restore(stage(), body_, begin, end, c_.by_bodies);
    }
    Checkpoint::Stage stage() const {
        return Checkpoint::Stage(std::uint32_t(Checkpoint::Stage::bodies) + std::uint32_t(round_));
    }

    Round& paths_;
    Checkpoint& checkpoint_;
    int round_;
    std::uint32_t body_;
    Contributions& c_;
};

}  // namespace

std::vector<DiffusionReport> gather_indirect(const Scene& scene, const RayScene& rays,
                                             std::vector<SampledBody>& bodies,
                                             const IndirectOptions& options, Checkpoint& checkpoint,
                                             Progress& progress) {
    std::vector<BodyView> views;         // [body] without indirect light
    std::vector<BodyExitance> exitance;  // [body]
    std::vector<Contributions> light;    // [body]
    views.reserve(bodies.size());
    std::vector<DiffusionReport> worst(bodies.size());
    std::size_t samples = 0;
    for (SampledBody& body : bodies) {
        views.push_back(body.view());
        exitance.emplace_back(
            views.back(), scene, Orders::all, ExitanceUse::paths,
            flights_in(rays, body.object, subsurface(scene, body.object)->medium.eta),
            DiffusionWish{double(options.tolerance)});
        const std::size_t count = body.samples.size();
        light.push_back({dark(scene.groups.size(), count), {}});
        samples += count;
    }
    const std::size_t chunk =
        std::max<std::size_t>(kBlock, kRaysPerChunk / std::size_t(options.rays));
    progress.begin("indirect", samples * std::size_t(options.bounces), "samples");
    for (int round = 0; round < options.bounces; ++round) {
        std::vector<GroupFields> fields(scene.objects.size());
        for (std::size_t b = 0; b < bodies.size(); ++b)
            fields[bodies[b].object] =
                make_fields(scene, bodies[b].view(), exitance[b], options.tolerance, worst[b]);
        for (SampledBody& body : bodies) body.indirect = {};  // the fields have it
        for (std::size_t b = 0; b < bodies.size(); ++b) {
            light[b].by_bodies = dark(scene.groups.size(), bodies[b].samples.size());
            Round paths(scene, rays, fields, options, bodies[b],
                        round == 0 ? LightPaths::Collect::everything : LightPaths::Collect::bodies,
                        light[b].by_surfaces, light[b].by_bodies);
            BodyRound body(paths, checkpoint, round, std::uint32_t(b), light[b]);
            const std::size_t count = bodies[b].samples.size();
            for (std::size_t begin = 0; begin < count; begin += chunk) {
                const std::size_t end = std::min(count, begin + chunk);
                body.gather(begin, end);
                progress.add(end - begin);
            }
        }
        // Only now: all bodies were to see the same light.
        for (std::size_t b = 0; b < bodies.size(); ++b) {
            bodies[b].indirect = std::move(light[b].by_bodies);
            add(bodies[b].indirect, light[b].by_surfaces);
            tint_irradiance(scene, rays, bodies[b].object, bodies[b].samples, bodies[b].indirect);
        }
    }
    progress.end();
    return worst;
}

}  // namespace tallow
