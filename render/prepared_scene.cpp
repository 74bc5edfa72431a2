// SPDX-License-Identifier: Apache-2.0
// Scene, geometry and cache -> all that does not depend on the camera.
#include "render/prepared_scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/check.h"
#include "common/exitance/scene_plan.h"
#include "common/lighting/flights.h"
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

// In place of what was decided before, if a scene is changed.
void decide(Plan& plan, Decision decision) {
    std::erase_if(plan.decisions, [&](const Decision& d) {
        return d.subject == decision.subject && d.term == decision.term;
    });
    plan.decisions.push_back(std::move(decision));
}

bool is_same(const ExitanceSource& a, const ExitanceSource& b) {
    return a.model == b.model && a.orders == b.orders && a.shifts == b.shifts &&
           a.boundary_elements == b.boundary_elements && a.exit == b.exit &&
           a.tolerance == b.tolerance && a.medium.sigma_a == b.medium.sigma_a &&
           a.medium.sigma_s_prime == b.medium.sigma_s_prime && a.medium.g == b.medium.g &&
           a.medium.eta == b.medium.eta;
}

}  // namespace

PreparedScene::PreparedScene(Scene scene, const SceneGeometry& geometry, CacheView cache,
                             ExitanceAccuracy accuracy,
                             const std::vector<std::optional<Rgb>>& diffuse, Stats& stats)
    : geometry_(geometry),
      cache_(std::move(cache)),
      accuracy_(accuracy),
      rays_(build_rays(geometry, stats)),
      bodies_(scene.objects.size()) {
    prepare(std::move(scene), diffuse, stats);
}

void PreparedScene::change(Scene scene, ExitanceAccuracy accuracy,
                           const std::vector<std::optional<Rgb>>& diffuse, Stats& stats) {
    accuracy_ = accuracy;
    TALLOW_CHECK(scene.objects.size() == bodies_.size(), "{} objects, {} before",
                 scene.objects.size(), bodies_.size());
    prepare(std::move(scene), diffuse, stats);
}

void PreparedScene::prepare(Scene scene, const std::vector<std::optional<Rgb>>& diffuse,
                            Stats& stats) {
    scene_ = std::move(scene);
    lit_ = without_dark_lights(scene_);
    prepare_bodies(diffuse, stats);
    clear_ = find_clear_bodies();
    albedos_.clear();
    for (const Material& material : scene_.materials) albedos_.push_back(albedo(material));
    const int bounces = indirect_bounces(scene_);
    reflected_.emplace(lit_, rays_, bounces, diffuse);
    indirect_ = bounces > 0 && has_opaque_surface(scene_, diffuse);
}

// A body that is taken for a diffuse surface is opaque, unless that is because nothing scatters in
// it.
std::vector<bool> PreparedScene::find_clear_bodies() const {
    std::vector<bool> clear(scene_.objects.size());
    for (std::size_t i = 0; i < clear.size(); ++i) {
        const SubsurfaceMaterial* material = subsurface(scene_, i);
        clear[i] = material != nullptr && material->transmission == Switch::on &&
                   (bodies_[i] || max_channel(material->medium.sigma_s_prime) == 0);
    }
    return clear;
}

void PreparedScene::prepare_bodies(const std::vector<std::optional<Rgb>>& diffuse, Stats& stats) {
    stats.counts["samples"] = stats.counts["lit_samples"] = std::int64_t(0);
    for (const BodyView& view : cache_.bodies) {
        std::optional<PreparedBody>& body = bodies_[view.object];
        if (!diffuse.empty() && diffuse[view.object]) {  // made for another tolerance or camera
            body.reset();
            continue;
        }
        PreparedBody prepared = prepare_body(view, body, stats);
        follow_inner_light(view, prepared, stats);
        body.emplace(std::move(prepared));
        add_count(stats, "samples", std::int64_t(view.positions.size()));
    }
    report_diffusion(stats);
}

// Left out where it would change the picture by less than a third of the tolerance: in pictures its
// root mean square is up to five times its mean (armadillo), which is what is measured.
void PreparedScene::follow_inner_light(const BodyView& view, PreparedBody& body,
                                       Stats& stats) const {
    if (!body.connections) return;
    const PhaseTimer timer(stats, "inner");
    const SubsurfaceMaterial& material = *body.material;
    const double of_picture = 5 * single_scattering_share(material.model, material.medium);
    const double allowed = scene_.settings.everything ? 0 : double(accuracy_.tolerance) / 3;
    InnerLight inner({lit_, rays_, surface(view.object), view.object, material.medium,
                      &*body.connections, material.albedo},
                     {view.positions, view.normals, view.areas}, allowed / of_picture);
    decide(stats.plan,
           {fmt::format("objects[{}]", view.object), "light reflected inside", !inner.empty(),
            inner.empty() ? "left out" : "followed to where it scatters once",
            fmt::format("{:.2g} of what is scattered once", inner.share()),
            inner.empty() ? std::optional(inner.share() * of_picture) : std::nullopt});
    if (!inner.empty()) body.inner.emplace(std::move(inner));
}

PreparedBody PreparedScene::prepare_body(const BodyView& view, std::optional<PreparedBody>& before,
                                         Stats& stats) const {
    const SubsurfaceMaterial& material = *subsurface(scene_, view.object);
    const Orders orders = orders_of_exitance(material);
    const ExitanceSource source{material.model,
                                material.medium,
                                orders,
                                material.shifts,
                                material.boundary_elements,
                                material.exit,
                                scene_.settings.tolerance};
    const bool same = before && is_same(before->source, source);
    PhaseTimer diffusion_timer(stats, material.boundary_elements ? "diffusion" : "octree");
    BodyExitance exitance_of =
        same ? std::move(before->exitance_of)
             : BodyExitance(view, scene_, orders, ExitanceUse::seen,
                            flights_in(rays_, view.object, material.medium.eta),
                            DiffusionWish{double(source.tolerance)});
    const Rgb gain = indirect_bounces(scene_) > 0 ? exitance_of.indirect_gain() : Rgb(0);
    GroupDiffusion diffusion{gain, {}};
    if (same && before->diffusion.indirect_gain == gain) diffusion = std::move(before->diffusion);
    const BodyDiffusion::Solution solution = solve(view, exitance_of, diffusion);
    const DiffusionReport report = exitance_of.report(solution);
    diffusion_timer.stop();

    const PhaseTimer timer(stats, "octree");
    const LitSamples samples = light_samples(view, scene_.groups, gain);
    add_count(stats, "lit_samples", std::int64_t(samples.position.size()));
    ExitanceField exitance = exitance_of.field(samples, solution, accuracy_);
    PreparedBody body{&material,
                      surface_factors(material),
                      source,
                      std::move(exitance_of),
                      std::move(diffusion),
                      report,
                      std::move(exitance),
                      march_steps_of_pixel(material, geometry_.surfaces[view.object],
                                           scene_.settings, accuracy_.tolerance),
                      std::nullopt,
                      std::nullopt,
                      LampPaths::sky_drawn};
    if (material.single_scattering == Switch::off || material.connection == Connection::straight)
        return body;
    if (triangles_in_reach(geometry_.surfaces[view.object], material.medium) > kMostInReach)
        body.lamps = LampPaths::drawn;
    if (before && before->connections)
        body.connections.emplace(std::move(*before->connections));  // eta belongs to the cache
    else
        body.connections.emplace(geometry_.surfaces[view.object], material.medium.eta);
    return body;
}

BodyDiffusion::Solution PreparedScene::solve(const BodyView& view, const BodyExitance& exitance_of,
                                             GroupDiffusion& diffusion) const {
    BodyDiffusion::Solution sum;
    if (exitance_of.clusters() == 0) return sum;
    const std::vector<LightGroup>& groups = scene_.groups;
    diffusion.of_group.resize(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (max_channel(groups[g].scale) == 0) continue;
        std::optional<BodyDiffusion::Solution>& of_group = diffusion.of_group[g];
        if (!of_group) {
            std::vector<LightGroup> only(groups.size(), {"", Rgb(0)});
            only[g].scale = Rgb(1);
            const LitSamples lit = light_samples(view, only, diffusion.indirect_gain);
            of_group = exitance_of.solve(lit);
        }
        sum.add(groups[g].scale, *of_group);
    }
    return sum;
}

void PreparedScene::report_diffusion(Stats& stats) const {
    std::int64_t clusters = 0, iterations = 0;
    for (std::size_t object = 0; object < bodies_.size(); ++object) {
        if (!bodies_[object]) continue;
        const DiffusionReport& report = bodies_[object]->report;
        for (const Decision& decision : diffusion_decisions(object, report))
            decide(stats.plan, decision);
        if (report.clusters == 0) continue;
        clusters += std::int64_t(report.clusters);
        iterations = std::max(iterations, std::int64_t(report.iterations));
        stats.errors[fmt::format("objects[{}].diffusion", object)] = report.error;
        stats.errors[fmt::format("objects[{}].diffusion_converged", object)] =
            std::int64_t(report.converged);
    }
    if (clusters == 0) return;
    stats.counts["clusters"] = clusters;
    stats.counts["diffusion_iterations"] = iterations;
}

std::vector<std::string> PreparedScene::warnings() const {
    std::vector<std::string> result;
    for (std::size_t object = 0; object < bodies_.size(); ++object) {
        if (!bodies_[object]) continue;
        const std::string warning =
            diffusion_warning(bodies_[object]->report, double(scene_.settings.tolerance));
        if (!warning.empty()) result.push_back(scene_.objects[object].where + ": " + warning);
    }
    return result;
}

}  // namespace tallow
