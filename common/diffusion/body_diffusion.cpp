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

constexpr float kSumTolerance = 3e-3f;
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

/// Sums at the clusters over the samples, moved, of one channel.
class ClusterSums {
public:
    ClusterSums(const EnteringLight& light, const SurfaceClusters& clusters,
                std::span<const std::int64_t> own_sample, const ReducedChannel& reduced,
                const ChannelDiffusion& channel, int c)
        : light_(light),
          clusters_(clusters),
          own_sample_(own_sample),
          mfp_(1 / reduced.sigma_t_prime),
          alpha_prime_(reduced.alpha_prime),
          channel_(channel),
          constants_(diffusion_constants(reduced.absorption, reduced.eta)),
          unit_(KernelTable::unit_near(mfp_)),
          targets_(clusters.position, unit_),
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

    // [cluster] factor * sum of the flux of samples times kernel, each sample acting at `places`
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
        std::vector<float> sums(clusters_.count()), evaluations(sums.size());
        point_sum.evaluate(targets_, kSumTolerance, {sums, evaluations, {}});
        std::vector<double> result(sums.size());
        parallel_for(result.size(), 64, [&](std::size_t i) {
            result[i] = factor * (double(sums[i]) + own_cell(i, kernel, places, source));
        });
        return result;
    }

    // What the cell of the cluster's own sample sends to it beyond what it does as points.
    template <class SourceOf>
    double own_cell(std::size_t cluster, const Kernel& kernel, std::size_t places,
                    const SourceOf& source) const {
        if (own_sample_[cluster] < 0) return 0;
        const auto i = std::size_t(own_sample_[cluster]);
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
    const SurfaceClusters& clusters_;
    std::span<const std::int64_t> own_sample_;
    double mfp_, alpha_prime_;
    ChannelDiffusion channel_;
    DiffusionConstants constants_;
    double unit_;
    TargetGroups targets_;
    int c_;
    double range_;
};

// [cluster] where its own sample is in the light, or -1 if it is dark.
std::vector<std::int64_t> own_samples(const SurfaceClusters& clusters, const EnteringLight& light,
                                      std::size_t samples) {
    std::vector<std::int64_t> lit(samples, -1), own(clusters.count());
    for (std::size_t i = 0; i < light.index.size(); ++i) lit[light.index[i]] = std::int64_t(i);
    for (std::size_t i = 0; i < own.size(); ++i) own[i] = lit[clusters.nearest[i]];
    return own;
}

}  // namespace

float BodyDiffusion::deepest_source(const Medium& medium) {
    return float(kDepths[std::size(kDepths) - 1].t) * max_channel(medium.mean_free_path());
}

BodyDiffusion::BodyDiffusion(const SampledSurface& samples, const Medium& medium, Rgb images,
                             std::size_t clusters)
    : medium_(medium), images_(images) {
    double area = 0;
    for (const float a : samples.area) area += double(a);
    tree_ = build_patch_tree(samples, largest_cluster_area(area, clusters));
    clusters_ = cut_clusters(samples, tree_, largest_cluster_area(area, clusters));
    for (int c = 0; c < 3; ++c) channels_[std::size_t(c)] = channel_diffusion(medium, c);
    operator_.emplace(samples, tree_, clusters_, channels_);
}

BodyDiffusion::Solution BodyDiffusion::solve(const EnteringLight& light) const {
    const std::size_t n = clusters_.count();
    Solution result{std::vector<Rgb>(n), std::vector<Rgb>(n)};
    if (light.position.empty()) return result;
    const auto own = own_samples(clusters_, light, tree_.order.size());
    std::array<BoundaryOperator::Solution, 3> solutions;
    parallel_for(3, 1, [&](std::size_t c) {
        const ChannelDiffusion& channel = channels_[c];
        const ClusterSums sums(light, clusters_, own, reduced_channel(medium_, int(c)), channel,
                               int(c));
        const auto S = sums.in_infinite_medium();
        const auto Hs = sums.in_half_space(double(images_[int(c)]));
        std::vector<double> guess(n);
        for (std::size_t i = 0; i < n; ++i) guess[i] = 2 * channel.A * Hs[i];
        solutions[c] = operator_->solve(int(c), S, guess, kSolveTolerance);
        for (std::size_t i = 0; i < n; ++i) {
            result.B[i][int(c)] = float(std::max(0.0, solutions[c].phi[i] / (2 * channel.A)));
            result.Hs[i][int(c)] = float(Hs[i]);
        }
    });
    for (const BoundaryOperator::Solution& solution : solutions) {
        result.iterations = std::max(result.iterations, solution.iterations);
        result.converged = result.converged && solution.converged;
    }
    return result;
}

}  // namespace tallow
