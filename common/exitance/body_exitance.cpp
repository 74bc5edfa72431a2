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
    : body_(body), use_(use), orders_(orders), profile_gain_(1), follow_(std::move(follow)) {
    const SubsurfaceMaterial& material = *subsurface(scene, body.object);
    if (orders != Orders::all) profile_gain_ = tallow::indirect_gain(material);
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
    for (int c = 0; c < 3; ++c) first_order_[c] = float(first_order_marched(medium_, c));
    if (orders == Orders::all)
        two_and_more_.emplace(make_exitance_kernels(material.model, material.medium,
                                                    Orders::two_and_more, body.spacing_mm));
    directional_ = material.exit == Exit::directional;
    // Where light leaves by its direction, that says where it came from.
    if (directional_) shifts_.exit = {};
    diffusion_.emplace(SampledSurface{body.positions, body.normals, body.areas}, material.medium,
                       cluster_wish(wish, body.area_mm2, material.medium.mean_free_path(), solved),
                       follow_, solved);
}

Rgb BodyExitance::indirect_gain() const {
    if (!diffusion_) return profile_gain_;
    return Rgb(1) + (Rgb(1) - strength_) * (profile_gain_ - Rgb(1));
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
    const std::vector<Rgb> once = first_order(lit);
    return diffusion_->solve({lit.position, lit.normal, lit.w_i, lit.E_t, lit.area, flights,
                              lit.index, lit.nodes, once});
}

// Light that is to leave also after one scattering: where that is not marched for direct light, all
// of it, else indirect light. Empty if there is none.
std::vector<Rgb> BodyExitance::first_order(const LitSamples& lit) const {
    std::vector<Rgb> light;
    if (orders_ != Orders::all && lit.E_direct.empty()) return light;
    light.reserve(lit.E_t.size());
    for (std::size_t i = 0; i < lit.E_t.size(); ++i) {
        const Rgb marched = orders_ == Orders::all ? Rgb(0) : lit.E_direct[i];
        light.push_back(first_order_ * (lit.E_t[i] - marched));
    }
    return light;
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
        "tolerance of {:.3g}: a smaller settings.tolerance takes more of them",
        report.clusters, report.error, tolerance);
}

ExitanceField BodyExitance::field(const LitSamples& lit, const BodyDiffusion::Solution& solution,
                                  ExitanceAccuracy accuracy) const {
    // Where paths end the control variate's irradiance is not known, and its edges do not matter.
    const ExitanceKernels profiles{kernels_->profiles};
    ExitanceField field(body_, lit, use_ == ExitanceUse::paths ? profiles : *kernels_, accuracy,
                        shifts_);
    if (!diffusion_ || solution.radiance.empty()) return field;
    const auto of_profiles = [&](const std::array<KernelTable, 3>& tables) {
        return at_clusters(ExitanceField(body_, lit, ExitanceKernels{tables}, accuracy, shifts_));
    };
    const std::vector<Rgb> P =
        field.needs_irradiance() ? of_profiles(kernels_->profiles) : at_clusters(field);
    std::vector<Rgb> rest = two_and_more_ ? of_profiles(two_and_more_->profiles) : P;
    for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = rest[i] - solution.fine.H[i];
    field.correct(LeavingField(diffusion_->clusters(),
                               {solution.radiance, rest, P, solution.entry.E, solution.entry.E_mu},
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
