// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/body_diffusion.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "common/base/parallel.h"
#include "common/nbody/point_sum.h"
#include "common/nbody/target_groups.h"
#include "common/optics/diffusion.h"

namespace tallow {
namespace {

// Where light first scatters along a beam, in reduced mean free paths: a quadrature of e^-t.
struct Depth {
    double t, weight;
};
constexpr Depth kDepths[] = {
    {.0601, .12}, {.2614, .22}, {.5978, .24}, {1.1593, .24}, {2.5257, .18}};

constexpr float kSumTolerance = 5e-3f;
constexpr double kSolveTolerance = 1e-4;

ChannelDiffusion channel_diffusion(const Medium& medium, int c) {
    const ReducedChannel reduced = reduced_channel(medium, c);
    const DiffusionConstants k = diffusion_constants(reduced.absorption, reduced.eta);
    return {k.D / reduced.sigma_t_prime, k.s * reduced.sigma_t_prime, k.A};
}

Vec3 tangential(Vec3 w, Vec3 n) { return w - glm::dot(w, n) * n; }

double diagonal(std::span<const Vec3> positions) {
    Vec3 low = positions[0], high = low;
    for (const Vec3& x : positions) low = glm::min(low, x), high = glm::max(high, x);
    return double(glm::length(high - low));
}

// A sample that is as near as its own cell is wide does not act as a point: its cell is summed over
// so many points instead.
constexpr int kCellPoints = 32;

/// Points spread evenly over a disc of the sample's area in its tangent plane.
class Cell {
public:
    Cell(Vec3 normal, float area) : radius_(std::sqrt(area / std::numbers::pi_v<float>)) {
        const Frame frame = make_frame(normal);
        s_ = frame.s, t_ = frame.t;
    }
    Vec3 point(int k) const {
        constexpr float kGoldenAngle = 2.39996323f;
        const float r = radius_ * std::sqrt((float(k) + 0.5f) / kCellPoints);
        return r *
               (std::cos(kGoldenAngle * float(k)) * s_ + std::sin(kGoldenAngle * float(k)) * t_);
    }

private:
    float radius_;
    Vec3 s_, t_;
};

/// Sums at places of the surface over the samples, moved, of one channel.
class ClusterSums {
public:
    /// `own_sample` [place] in the light, or -1; see own_samples().
    ClusterSums(const EnteringLight& light, std::span<const Vec3> places,
                std::span<const std::int64_t> own_sample, const ReducedChannel& reduced,
                const ChannelDiffusion& channel, int c)
        : light_(light),
          own_sample_(own_sample),
          mfp_(1 / reduced.sigma_t_prime),
          alpha_prime_(reduced.alpha_prime),
          channel_(channel),
          constants_(diffusion_constants(reduced.absorption, reduced.eta)),
          unit_(KernelTable::unit_near(mfp_)),
          targets_(places, unit_),
          c_(c),
          range_(diagonal(light.position) + 10 * mfp_) {}

    /// S: fluence that the sources would have in an infinite medium.
    std::vector<double> in_infinite_medium() const {
        const double s = channel_.s;
        const auto kernel = [&](double r2) {
            const double d = std::sqrt(r2 + kSoftening * kSoftening * mfp_ * mfp_);
            return std::exp(-s * d) / d;
        };
        const double factor = alpha_prime_ / (4 * std::numbers::pi * channel_.D);
        return sum(kernel, factor, std::size(kDepths), [&](std::size_t i, std::size_t k) {
            Source at = source(i, float(kDepths[k].t * mfp_));
            at.share *= float(kDepths[k].weight);
            return at;
        });
    }

    /// Hs: exitance that the same sources have in a half-space.
    std::vector<double> in_half_space(double images) const {
        const double to_units = 1 / mfp_;
        const auto kernel = [&](double r2) {
            const double u = r2 * to_units * to_units;
            double sum = 0;
            for (const Depth& depth : kDepths) {
                double fluence = 0;
                if (images > 0) fluence += images * image_pair(u, depth.t, constants_).fluence;
                if (images < 1)
                    fluence += (1 - images) * half_space_fluence(u, depth.t, constants_);
                sum += depth.weight * fluence;
            }
            return sum * to_units;
        };
        const double factor = alpha_prime_ / (8 * std::numbers::pi * channel_.A * channel_.D);
        return sum(kernel, factor, 1, [&](std::size_t i, std::size_t) {
            return Source{float(mfp_) * tangential(light_.w_i[i], light_.normal[i]), 1};
        });
    }

private:
    using Kernel = std::function<double(double)>;

    // The kernel out to the farthest pair of points of the body.
    KernelTable tabulate_far(const Kernel& kernel) const {
        return {kernel, mfp_, unit_, std::max(kernel(range_ * range_) * 1e-2, 1e-30)};
    }

    /// Where the light of a sample acts, and how much of it.
    struct Source {
        Vec3 offset;  // from the sample, mm
        float share;
    };

    // Of the light that first scatters after t mm: beyond the end of its beam, what is mirrored.
    Source source(std::size_t i, float t) const {
        const Beam& beam = light_.beams[i];
        if (t <= beam.length) return {t * light_.w_i[i], 1};
        return {beam.length * light_.w_i[i] + (t - beam.length) * beam.w, beam.reflected};
    }

    // [place] factor * sum of the flux of samples times kernel, each sample acting at `places`
    // places as source(sample, place) says. All are points of one tree: from afar they act
    // together.
    template <class SourceOf>
    std::vector<double> sum(const Kernel& kernel, double factor, std::size_t places,
                            const SourceOf& source) const {
        const std::size_t n = light_.area.size();
        std::vector<Vec3> positions(places * n);
        std::vector<float> flux(places * n);
        parallel_for(n, 4096, [&](std::size_t i) {
            for (std::size_t k = 0; k < places; ++k) {
                const Source at = source(i, k);
                positions[i * places + k] = light_.position[i] + at.offset;
                flux[i * places + k] = at.share * light_.area[i] * light_.E_t[i][c_];
            }
        });
        std::vector<OctreeNode> nodes(light_.nodes.begin(), light_.nodes.end());
        for (OctreeNode& node : nodes)
            node.first *= std::uint32_t(places), node.count *= std::uint32_t(places);
        const PointSum point_sum(positions, flux, nodes, tabulate_far(kernel));
        std::vector<float> sums(own_sample_.size()), evaluations(sums.size());
        point_sum.evaluate(targets_, kSumTolerance, {sums, evaluations, {}});
        std::vector<double> result(sums.size());
        parallel_for(result.size(), 64, [&](std::size_t i) {
            // Where samples are far apart, what is taken off for the own cell is rounding at best.
            result[i] =
                factor * std::max(0.0, double(sums[i]) + own_cell(i, kernel, places, source));
        });
        return result;
    }

    // What the cell of a place's own sample sends to it beyond what it does as points.
    template <class SourceOf>
    double own_cell(std::size_t at_place, const Kernel& kernel, std::size_t places,
                    const SourceOf& source) const {
        if (own_sample_[at_place] < 0) return 0;
        const auto i = std::size_t(own_sample_[at_place]);
        const Cell cell(light_.normal[i], light_.area[i]);
        double sum = 0;
        for (std::size_t p = 0; p < places; ++p) {
            const Source at = source(i, p);
            double mean = 0;
            for (int k = 0; k < kCellPoints; ++k)
                mean += kernel(double(length2(at.offset + cell.point(k)))) / kCellPoints;
            sum += double(at.share) * (mean - kernel(double(length2(at.offset))));
        }
        return double(light_.area[i] * light_.E_t[i][c_]) * sum;
    }

    // Of the distance from a source in an infinite medium, mean free paths; well below the first
    // depth.
    static constexpr double kSoftening = 0.02;

    const EnteringLight& light_;
    std::span<const std::int64_t> own_sample_;
    double mfp_, alpha_prime_;
    ChannelDiffusion channel_;
    DiffusionConstants constants_;
    double unit_;
    TargetGroups targets_;
    int c_;
    double range_;
};

// [place] where its own sample is in the light, or -1 if it is dark; `own` [place] is that sample.
std::vector<std::int64_t> own_samples(std::span<const std::uint32_t> own,
                                      const EnteringLight& light, std::size_t samples) {
    std::vector<std::int64_t> lit(samples, -1), result;
    for (std::size_t i = 0; i < light.index.size(); ++i) lit[light.index[i]] = std::int64_t(i);
    for (const std::uint32_t i : own) result.push_back(lit[i]);
    return result;
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

float BodyDiffusion::deepest_source(const Medium& medium) {
    return float(kDepths[std::size(kDepths) - 1].t) * max_channel(medium.mean_free_path());
}

BodyDiffusion::BodyDiffusion(const SampledSurface& samples, const Medium& medium, Rgb images,
                             const ClusterWish& wish, std::array<bool, 3> solved)
    : medium_(medium), images_(images), solved_(solved), samples_(samples.size()) {
    for (int c = 0; c < 3; ++c) channels_[std::size_t(c)] = channel_diffusion(medium, c);
    const PatchTree tree =
        build_patch_tree(samples, largest_cluster_area(total(samples.area), wish.most));
    const double largest = choose_largest_area(samples, tree, wish);
    fine_.clusters = cut_clusters(samples, tree, largest);
    coarse_.clusters = cut_clusters(samples, tree, kCoarser * largest, kCoarseVariance);
    for (Level* level : {&fine_, &coarse_})
        level->equation.emplace(samples, tree, level->clusters, channels_);
    for (std::uint32_t i = 0, parent = 0; i < fine_.clusters.count(); ++i) {
        const auto end = [&](std::uint32_t k) {
            return tree.patches[coarse_.clusters.patch[k]].end;
        };
        while (tree.patches[fine_.clusters.patch[i]].begin >= end(parent)) ++parent;
        parent_.push_back(parent);
    }
}

BodyDiffusion::Solution BodyDiffusion::solve(const EnteringLight& light) const {
    Solution result;
    for (Fields* fields : {&result.fine, &result.coarse}) {
        const std::size_t n =
            fields == &result.fine ? clusters().count() : coarse_.clusters.count();
        fields->B.assign(n, Rgb(0)), fields->Hs.assign(n, Rgb(0));
    }
    if (light.position.empty()) return result;
    std::vector<Vec3> places = fine_.clusters.position;
    places.insert(places.end(), coarse_.clusters.position.begin(), coarse_.clusters.position.end());
    std::vector<std::uint32_t> nearest = fine_.clusters.nearest;
    nearest.insert(nearest.end(), coarse_.clusters.nearest.begin(), coarse_.clusters.nearest.end());
    const auto own = own_samples(nearest, light, samples_);
    std::array<ChannelReport, 3> reports;
    parallel_for(3, 1, [&](std::size_t c) {
        if (!solved_[c]) return;
        const ClusterSums sums(light, places, own, reduced_channel(medium_, int(c)), channels_[c],
                               int(c));
        reports[c] = solve_channel(int(c), sums.in_infinite_medium(),
                                   sums.in_half_space(double(images_[int(c)])), result);
    });
    for (const ChannelReport& report : reports) {
        result.iterations = std::max(result.iterations, report.iterations);
        result.converged = result.converged && report.converged;
    }
    return result;
}

// `S` and `Hs` [place]: fine clusters, then coarse ones.
BodyDiffusion::ChannelReport BodyDiffusion::solve_channel(int c, const std::vector<double>& S,
                                                          const std::vector<double>& Hs,
                                                          Solution& result) const {
    const std::size_t n = fine_.clusters.count(), m = coarse_.clusters.count();
    const double to_fluence = 2 * channels_[std::size_t(c)].A;
    const auto fine_Hs = part(Hs, 0, n), coarse_Hs = part(Hs, n, m);
    std::vector<double> guess(m);
    for (std::size_t k = 0; k < m; ++k) guess[k] = to_fluence * coarse_Hs[k];
    const auto coarse = coarse_.equation->solve(c, part(S, n, m), guess, kSolveTolerance);
    guess.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t k = parent_[i];
        guess[i] = coarse_Hs[k] > 0 ? fine_Hs[i] / coarse_Hs[k] * coarse.phi[k] : coarse.phi[k];
    }
    const auto fine = fine_.equation->solve(c, part(S, 0, n), guess, kSolveTolerance);
    if (!all_finite(coarse.phi) || !all_finite(fine.phi)) return {fine.iterations, false};
    const auto put = [&](const std::vector<double>& phi, const std::vector<double>& H,
                         Fields& fields) {
        for (std::size_t i = 0; i < phi.size(); ++i) {
            fields.B[i][c] = float(std::max(0.0, phi[i] / to_fluence));
            fields.Hs[i][c] = float(H[i]);
        }
    };
    put(fine.phi, fine_Hs, result.fine);
    put(coarse.phi, coarse_Hs, result.coarse);
    return {fine.iterations, fine.converged && coarse.converged};
}

void BodyDiffusion::Solution::add(Rgb scale, const Solution& b) {
    tallow::add(fine.B, scale, b.fine.B), tallow::add(fine.Hs, scale, b.fine.Hs);
    tallow::add(coarse.B, scale, b.coarse.B), tallow::add(coarse.Hs, scale, b.coarse.Hs);
    iterations = std::max(iterations, b.iterations);
    converged = converged && b.converged;
}

ClusterRatio BodyDiffusion::ratio(const Solution& solution, Rgb strength) const {
    return {fine_.clusters, solution.fine.B, solution.fine.Hs, strength};
}

double BodyDiffusion::estimate_error(const Solution& solution, Rgb strength) const {
    const ClusterRatio fine = ratio(solution, strength);
    const ClusterRatio coarse(coarse_.clusters, solution.coarse.B, solution.coarse.Hs, strength);
    const std::size_t n = fine_.clusters.count();
    std::vector<double> squares(n), sums(n);
    parallel_for(n, 64, [&](std::size_t i) {
        const Vec3 x = fine_.clusters.position[i], normal = fine_.clusters.normal[i];
        const Rgb of_fine = fine.at(x, normal), of_coarse = coarse.at(x, normal);
        for (int c = 0; c < 3; ++c) {
            const double Hs = double(solution.fine.Hs[i][c]), a = double(fine_.clusters.area[i]);
            const double change = Hs * double(of_fine[c] - of_coarse[c]);
            squares[i] += a * change * change;
            sums[i] += a * Hs * double(of_fine[c]);
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
