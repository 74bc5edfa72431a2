// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/body_exitance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tallow {
namespace {

// Clusters of a body at a tolerance of 1 %; their number is inverse to the tolerance. Bodies whose
// normals differ on clusters by more than kVariance at 1 % (armadillo) have more of them. Chosen
// for time: docs/BODY_AWARE.md has error, time and memory against their number.
constexpr std::size_t kLeastClusters = 1000;
constexpr double kFewClusters = 2000, kManyClusters = 8000, kMostClusters = 32000;
constexpr double kVariance = 0.025;

// Light cannot tell a surface from one that is smoothed over a mean free path: clusters need not be
// smaller. `solved` are the channels that count.
ClusterWish cluster_wish(const DiffusionWish& wish, double area, Rgb mean_free_path,
                         const std::array<bool, 3>& solved) {
    if (wish.clusters > 0) return {wish.clusters, wish.clusters};
    const double tolerance = std::max(wish.tolerance, 1e-3);
    double length = double(kInfinity);
    for (int c = 0; c < 3; ++c)
        if (solved[std::size_t(c)]) length = std::min(length, double(mean_free_path[c]));
    const auto at_most = [&](double count) {
        const double clusters = std::min({count, kMostClusters, area / (length * length)});
        return std::max(kLeastClusters, std::size_t(clusters));
    };
    const double finer = 0.01 / tolerance;
    return {at_most(kFewClusters * finer), at_most(kManyClusters * finer), kVariance / finer};
}

// Samples that are farther apart than light travels cannot tell what the light does near them: the
// correction fades out while the mean free path falls from one spacing to half of it.
Rgb strength_at(Rgb mean_free_paths_of_spacing) {
    return map(mean_free_paths_of_spacing,
               [](float ratio) { return std::clamp(2 * ratio - 1, 0.0f, 1.0f); });
}

ExitanceShifts shifts_of(const SubsurfaceMaterial& material) {
    ExitanceShifts shifts;
    if (!material.shifts) return shifts;
    const Rgb length = material.medium.mean_free_path();
    for (int c = 0; c < 3; ++c) {
        shifts.entry[std::size_t(c)] = length[c];
        shifts.exit[std::size_t(c)] = length[c] / material.medium.eta;
    }
    return shifts;
}

}  // namespace

BodyExitance::BodyExitance(const BodyView& body, const Scene& scene, Orders orders, ExitanceUse use,
                           FollowFlights follow, DiffusionWish wish)
    : body_(body), use_(use), follow_(std::move(follow)) {
    const SubsurfaceMaterial& material = *subsurface(scene, body.object);
    kernels_.emplace(
        make_exitance_kernels(material.model, material.medium, orders, body.spacing_mm));
    shifts_ = shifts_of(material);
    strength_ = strength_at(material.medium.mean_free_path() / body.spacing_mm);
    wants_diffusion_ =
        material.boundary_elements && encloses_volume(scene.objects[body.object].shape);
    if (!wants_diffusion_ || max_channel(strength_) == 0 || body.positions.empty()) return;
    std::array<bool, 3> solved;
    for (int c = 0; c < 3; ++c) solved[std::size_t(c)] = strength_[c] > 0;
    medium_ = material.medium;
    directional_ = material.exit == Exit::directional;
    // Where light leaves by its direction, that says where it came from.
    if (directional_) shifts_.exit = {};
    diffusion_.emplace(SampledSurface{body.positions, body.normals, body.areas}, material.medium,
                       cluster_wish(wish, body.area_mm2, material.medium.mean_free_path(), solved),
                       follow_, orders, solved);
}

BodyDiffusion::Solution BodyExitance::solve(const LitSamples& lit) const {
    if (!diffusion_) return {};
    std::vector<Vec3> w(lit.w_i.size());
    for (std::size_t i = 0; i < w.size(); ++i) {
        const float length = glm::length(lit.w_i[i]);
        w[i] = length > 0 ? lit.w_i[i] / length : -lit.normal[i];
    }
    const std::vector<Flight> flights =
        follow_(lit.position, lit.normal, w, BodyDiffusion::longest_flight(medium_));
    return diffusion_->solve(
        {lit.position, lit.normal, lit.w_i, lit.E_t, lit.area, flights, lit.index, lit.nodes});
}

DiffusionReport BodyExitance::report(const BodyDiffusion::Solution& solution) const {
    if (!diffusion_) return {wants_diffusion_};
    return {true,
            clusters(),
            diffusion_->solved(),
            solution.iterations,
            solution.converged,
            diffusion_->estimate_error(solution, strength_)};
}

void add_worse(DiffusionReport& report, const DiffusionReport& b) {
    if (b.error >= report.error) report.clusters = b.clusters, report.error = b.error;
    report.wanted = report.wanted || b.wanted;
    for (std::size_t c = 0; c < 3; ++c) report.solved[c] = report.solved[c] || b.solved[c];
    report.iterations = std::max(report.iterations, b.iterations);
    report.converged = report.converged && b.converged;
}

std::vector<Decision> diffusion_decisions(std::size_t object, const DiffusionReport& report) {
    constexpr const char* kChannels[] = {"red", "green", "blue"};
    std::vector<Decision> decisions;
    if (!report.wanted) return decisions;
    for (std::size_t c = 0; c < 3; ++c)
        decisions.push_back(
            {fmt::format("objects[{}]", object),
             fmt::format("diffusion in the body, {}", kChannels[c]), report.solved[c],
             report.solved[c] ? fmt::format("{} boundary elements", report.clusters) : "not solved",
             report.solved[c] ? "samples resolve the mean free path"
                              : "samples are farther apart than two mean free paths",
             std::nullopt});
    return decisions;
}

std::string diffusion_warning(const DiffusionReport& report, double tolerance) {
    if (report.clusters == 0) return {};
    if (!report.converged)
        return fmt::format("diffusion on {} boundary elements did not converge", report.clusters);
    if (report.error <= kMostOfTolerance * tolerance) return {};
    return fmt::format(
        "diffusion on {} boundary elements is off by about {:.2g} of the light, above the "
        "tolerance "
        "of {}: a smaller settings.tolerance takes more of them",
        report.clusters, report.error, tolerance);
}

ExitanceField BodyExitance::field(const LitSamples& lit, const BodyDiffusion::Solution& solution,
                                  ExitanceAccuracy accuracy) const {
    // Where paths end the control variate's irradiance is not known, and its edges do not matter.
    const ExitanceKernels profiles{kernels_->profiles};
    ExitanceField field(body_, lit, use_ == ExitanceUse::paths ? profiles : *kernels_, accuracy,
                        shifts_);
    if (!diffusion_ || solution.radiance.empty()) return field;
    std::vector<Rgb> P;
    if (field.needs_irradiance())
        P = at_clusters(ExitanceField(body_, lit, profiles, accuracy, shifts_));
    else
        P = at_clusters(field);
    field.correct(
        LeavingField(diffusion_->clusters(),
                     {solution.radiance, solution.fine.H, P, solution.entry.E, solution.entry.E_mu},
                     medium_.eta, directional_, strength_));
    return field;
}

// What the profile alone gives at the clusters.
std::vector<Rgb> BodyExitance::at_clusters(const ExitanceField& field) const {
    const SurfaceClusters& clusters = diffusion_->clusters();
    std::vector<ExitancePoint> points(clusters.count());
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] = {clusters.position[i], clusters.normal[i], clusters.normal[i]};
    return field.gather(points).M;
}

}  // namespace tallow
