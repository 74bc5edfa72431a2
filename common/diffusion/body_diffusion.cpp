// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/body_diffusion.h"

#include <algorithm>
#include <cmath>

#include "common/base/parallel.h"
#include "common/diffusion/light_balance.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

// Chosen: a tenth of what the size of clusters leaves.
constexpr double kSolveTolerance = 1e-3;

ChannelDiffusion channel_diffusion(const Medium& medium, int c) {
    const ReducedChannel reduced = reduced_channel(medium, c);
    const DiffusionConstants k = diffusion_constants(reduced.absorption, reduced.eta);
    return {k.D / reduced.sigma_t_prime, k.s * reduced.sigma_t_prime, k.A};
}

// [sample of the surface] where it is in the light, or -1 if it is dark.
std::vector<std::int64_t> find_lit(const EnteringLight& light, std::size_t samples) {
    std::vector<std::int64_t> lit(samples, -1);
    for (std::size_t i = 0; i < light.index.size(); ++i) lit[light.index[i]] = std::int64_t(i);
    return lit;
}

// The farthest that a source can be from a point, mm.
double range(std::span<const Vec3> positions, const Medium& medium) {
    Vec3 low(kInfinity), high(-kInfinity);
    for (const Vec3& x : positions) low = glm::min(low, x), high = glm::max(high, x);
    return double(glm::length(high - low)) + 10 * double(max_channel(medium.mean_free_path()));
}

double total(std::span<const float> areas) {
    double sum = 0;
    for (const float a : areas) sum += double(a);
    return sum;
}

void add(std::vector<Rgb>& sum, Rgb scale, const std::vector<Rgb>& b) {
    sum.resize(b.size(), Rgb(0));
    for (std::size_t i = 0; i < b.size(); ++i) sum[i] += scale * b[i];
}

// Sums of the fine level come first, those of the coarse one after them.
std::vector<double> part(const std::vector<double>& sums, std::size_t first, std::size_t count) {
    return {sums.begin() + std::ptrdiff_t(first), sums.begin() + std::ptrdiff_t(first + count)};
}

bool all_finite(const std::vector<double>& values) {
    return std::ranges::all_of(values, [](double x) { return std::isfinite(x); });
}

// From few clusters on, twice as many until the wish is met.
double choose_largest_area(const SampledSurface& samples, const PatchTree& tree,
                           const ClusterWish& wish) {
    for (std::size_t count = wish.least; count < wish.most; count *= 2) {
        const double largest = largest_cluster_area(tree.area, count);
        if (normal_variance(tree, cut_clusters(samples, tree, largest)) <= wish.variance)
            return largest;
    }
    return largest_cluster_area(tree.area, wish.most);
}

// How much coarser the clusters are that the solution is compared with.
constexpr std::size_t kCoarser = 4;

// The error falls as the number of clusters to this power: measured, docs/BODY_AWARE.md.
constexpr double kOrder = 2.0 / 3;

// Coarse clusters may reach around edges, so that there are fewer of them on bumpy bodies as well;
// not through thin sheets.
constexpr double kCoarseVariance = 0.5;

}  // namespace

float BodyDiffusion::longest_flight(const Medium& medium) {
    return float(kLongestFlight) * max_channel(medium.mean_free_path());
}

BodyDiffusion::BodyDiffusion(const SampledSurface& samples, const Medium& medium,
                             const ClusterWish& wish, const FollowFlights& follow,
                             std::array<bool, 3> solved)
    : medium_(medium),
      solved_(solved),
      samples_(samples),
      tree_(build_patch_tree(samples, largest_cluster_area(total(samples.area), wish.most))) {
    const double reach = range(samples.position, medium);
    parallel_for(3, 1, [&](std::size_t c) {
        channels_[c] = channel_diffusion(medium, int(c));
        if (!solved[c]) return;
        const ReducedChannel reduced = reduced_channel(medium, int(c));
        kernels_[c].emplace(reduced, channels_[c], LightBalance(reduced), reach);
    });
    const double largest = choose_largest_area(samples, tree_, wish);
    fine_.clusters = cut_clusters(samples, tree_, largest);
    coarse_.clusters = cut_clusters(samples, tree_, kCoarser * largest, kCoarseVariance);
    for (Level* level : {&fine_, &coarse_})
        level->equation.emplace(samples, tree_, level->clusters, channels_);
    for (std::uint32_t i = 0, parent = 0; i < fine_.clusters.count(); ++i) {
        const auto end = [&](std::uint32_t k) {
            return tree_.patches[coarse_.clusters.patch[k]].end;
        };
        while (tree_.patches[fine_.clusters.patch[i]].begin >= end(parent)) ++parent;
        parent_.push_back(parent);
    }
    ways_.emplace(fine_.clusters.position, fine_.clusters.normal, follow, longest_flight(medium));
}

BodyDiffusion::Solution BodyDiffusion::solve(const EnteringLight& light) const {
    Solution result;
    for (Fields* fields : {&result.fine, &result.coarse}) {
        const std::size_t n =
            fields == &result.fine ? clusters().count() : coarse_.clusters.count();
        fields->B.assign(n, Rgb(0)), fields->H.assign(n, Rgb(0));
    }
    result.radiance.resize(clusters().count());
    const std::vector<std::int64_t> lit = find_lit(light, samples_.size());
    result.entry = find_entry(light, lit);
    if (light.position.empty()) return result;
    std::vector<Vec3> places = fine_.clusters.position;
    places.insert(places.end(), coarse_.clusters.position.begin(), coarse_.clusters.position.end());
    std::vector<std::uint32_t> nearest = fine_.clusters.nearest;
    nearest.insert(nearest.end(), coarse_.clusters.nearest.begin(), coarse_.clusters.nearest.end());
    std::vector<std::int64_t> own(nearest.size());
    std::ranges::transform(nearest, own.begin(), [&](std::uint32_t i) { return lit[i]; });
    std::array<ChannelReport, 3> reports;
    parallel_for(3, 1, [&](std::size_t c) {
        if (!solved_[c]) return;
        const SourceSums sums(light, *kernels_[c], double(medium_.mean_free_path()[int(c)]),
                              int(c));
        const std::vector<double> S = sums.in_infinite_medium(places, own);
        std::vector<double> phi;
        reports[c] = solve_channel(int(c), S, sums.leaving_half_space(places, own), result, phi);
        if (phi.empty()) return;
        const std::vector<LeavingRadiance> X = ways_->radiance(
            {sums, *kernels_[c], *fine_.equation, samples_, tree_, S, phi, own, int(c)});
        for (std::size_t i = 0; i < X.size(); ++i) result.radiance[i][c] = X[i];
        say_how_much(int(c), sums.leaving_once(ways_->places()), result);
    });
    for (const ChannelReport& report : reports) {
        result.iterations = std::max(result.iterations, report.iterations);
        result.converged = result.converged && report.converged;
    }
    return result;
}

BodyDiffusion::Entry BodyDiffusion::find_entry(const EnteringLight& light,
                                               std::span<const std::int64_t> lit) const {
    const SurfaceClusters& clusters = fine_.clusters;
    Entry entry{std::vector<Rgb>(clusters.count()), std::vector<Rgb>(clusters.count())};
    parallel_for(clusters.count(), 64, [&](std::size_t i) {
        for (const std::uint32_t s : tree_.samples(tree_.patches[clusters.patch[i]])) {
            if (lit[s] < 0) continue;
            const auto k = std::size_t(lit[s]);
            const Rgb E = light.area[k] / clusters.area[i] * light.E_t[k];
            entry.E[i] += E;
            entry.E_mu[i] += std::max(0.0f, -glm::dot(light.w_i[k], light.normal[k])) * E;
        }
    });
    return entry;
}

// `S` and `H` [place]: fine clusters, then coarse ones. `phi` [fine cluster] is left empty if there
// is none.
BodyDiffusion::ChannelReport BodyDiffusion::solve_channel(int c, const std::vector<double>& S,
                                                          const std::vector<double>& H,
                                                          Solution& result,
                                                          std::vector<double>& phi) const {
    const std::size_t n = fine_.clusters.count(), m = coarse_.clusters.count();
    const double to_fluence = 2 * channels_[std::size_t(c)].A;
    const auto fine_H = part(H, 0, n), coarse_H = part(H, n, m);
    std::vector<double> guess(m);
    for (std::size_t k = 0; k < m; ++k) guess[k] = to_fluence * coarse_H[k];
    const auto coarse = coarse_.equation->solve(c, part(S, n, m), guess, kSolveTolerance);
    guess.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t k = parent_[i];
        guess[i] = coarse_H[k] > 0 ? fine_H[i] / coarse_H[k] * coarse.phi[k] : coarse.phi[k];
    }
    const auto fine = fine_.equation->solve(c, part(S, 0, n), guess, kSolveTolerance);
    if (!all_finite(coarse.phi) || !all_finite(fine.phi)) return {fine.iterations, false};
    const auto put = [&](const std::vector<double>& of_phi, const std::vector<double>& of_H,
                         Fields& fields) {
        for (std::size_t i = 0; i < of_phi.size(); ++i) {
            fields.B[i][c] = float(std::max(0.0, of_phi[i] / to_fluence));
            fields.H[i][c] = float(std::max(0.0, of_H[i]));
        }
    };
    put(fine.phi, fine_H, result.fine);
    put(coarse.phi, coarse_H, result.coarse);
    phi = fine.phi;
    return {fine.iterations, fine.converged && coarse.converged};
}

// Lets the balance say how much leaves. What F misses of it is light that total reflection keeps in
// the body: it comes from everywhere alike, and most along ways on which much scatters.
void BodyDiffusion::say_how_much(int c, std::span<const LeavingOnce::Exitance> leaving_once,
                                 Solution& result) const {
    const ReducedChannel reduced = reduced_channel(medium_, c);
    const LightBalance balance(reduced);
    const float mean_cosine = mean_cosine_of_leaving(medium_.eta);
    parallel_for(leaving_once.size(), 256, [&](std::size_t i) {
        const Vec3 mean_way = mean_cosine * fine_.clusters.normal[i];
        const LeavingRadiance shape = ways_->of_even_fluence(i, 1 / reduced.sigma_t_prime);
        LeavingRadiance& X = result.radiance[i][std::size_t(c)];
        const double mean = double(X.at(mean_way));
        const LeavingOnce::Exitance once = leaving_once[i];
        const double missing =
            balance.leaving(double(result.fine.B[i][c]), once.all, mean) + once.part - mean;
        X.add(float(missing) / shape.at(mean_way), shape);
    });
}

void BodyDiffusion::Solution::add(Rgb scale, const Solution& b) {
    tallow::add(fine.B, scale, b.fine.B), tallow::add(fine.H, scale, b.fine.H);
    tallow::add(coarse.B, scale, b.coarse.B), tallow::add(coarse.H, scale, b.coarse.H);
    tallow::add(entry.E, scale, b.entry.E), tallow::add(entry.E_mu, scale, b.entry.E_mu);
    radiance.resize(b.radiance.size());
    for (std::size_t i = 0; i < radiance.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            LeavingRadiance& sum = radiance[i][std::size_t(c)];
            sum.add(scale[c], b.radiance[i][std::size_t(c)]);
        }
    iterations = std::max(iterations, b.iterations);
    converged = converged && b.converged;
}

ClusterRatio BodyDiffusion::ratio(const Solution& solution, Rgb strength) const {
    return {fine_.clusters, solution.fine.B, solution.fine.H, strength};
}

double BodyDiffusion::estimate_error(const Solution& solution, Rgb strength) const {
    const ClusterRatio fine = ratio(solution, strength);
    const ClusterRatio coarse(coarse_.clusters, solution.coarse.B, solution.coarse.H, strength);
    const std::size_t n = fine_.clusters.count();
    std::vector<double> squares(n), sums(n);
    parallel_for(n, 64, [&](std::size_t i) {
        const Vec3 x = fine_.clusters.position[i], normal = fine_.clusters.normal[i];
        const Rgb of_fine = fine.at(x, normal), of_coarse = coarse.at(x, normal);
        for (int c = 0; c < 3; ++c) {
            const double H = double(solution.fine.H[i][c]), a = double(fine_.clusters.area[i]);
            const double change = H * double(of_fine[c] - of_coarse[c]);
            squares[i] += a * change * change;
            sums[i] += a * H * double(of_fine[c]);
        }
    });
    double square = 0, sum = 0, area = 0;
    for (std::size_t i = 0; i < n; ++i) {
        square += squares[i], sum += sums[i];
        area += 3 * double(fine_.clusters.area[i]);
    }
    if (!(sum > 0)) return 0;
    const double finer = double(n) / double(coarse_.clusters.count());
    const double of_change = 1 / std::max(1.0, std::pow(finer, kOrder) - 1);
    return std::sqrt(square / area) / (sum / area) * of_change;
}

std::size_t BodyDiffusion::memory_bytes() const {
    return fine_.equation->memory_bytes() + coarse_.equation->memory_bytes();
}

}  // namespace tallow
