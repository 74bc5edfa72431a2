// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/body_diffusion.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
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

/// Sums at the clusters over the samples, moved, of one channel.
class ClusterSums {
public:
    ClusterSums(const EnteringLight& light, const SurfaceClusters& clusters,
                const ReducedChannel& reduced, const ChannelDiffusion& channel, int c)
        : light_(light),
          clusters_(clusters),
          mfp_(1 / reduced.sigma_t_prime),
          alpha_prime_(reduced.alpha_prime),
          channel_(channel),
          constants_(diffusion_constants(reduced.absorption, reduced.eta)),
          unit_(KernelTable::unit_near(mfp_)),
          targets_(clusters.position, unit_),
          flux_(light.area.size()),
          range_(diagonal(light.position) + 10 * mfp_) {
        for (std::size_t i = 0; i < flux_.size(); ++i) flux_[i] = light.area[i] * light.E_t[i][c];
    }

    /// S: fluence that the sources would have in an infinite medium.
    std::vector<double> in_infinite_medium() const {
        const double s = channel_.s;
        // No nearer than half the radius of a sample: its source is spread over its cell.
        const double soft = mfp_ * 0.05;
        const auto kernel = [&](double r2) {
            const double d = std::sqrt(r2 + soft * soft);
            return std::exp(-s * d) / d;
        };
        const double least = kernel(range_ * range_) * 1e-2;
        const KernelTable table(kernel, mfp_, unit_, std::max(least, 1e-30));
        std::vector<double> S(clusters_.count());
        const double factor = alpha_prime_ / (4 * std::numbers::pi * channel_.D);
        for (const Depth& depth : kDepths) {
            const float t = float(depth.t * mfp_);
            add(table, factor * depth.weight,
                [&](std::size_t i) { return light_.position[i] + t * light_.w_i[i]; }, S);
        }
        return S;
    }

    /// Hs: exitance that the same sources have in a half-space.
    std::vector<double> in_half_space() const {
        const double to_units = 1 / mfp_;
        const auto kernel = [&](double r2) {
            double sum = 0;
            for (const Depth& depth : kDepths)
                sum += depth.weight *
                       image_pair(r2 * to_units * to_units, depth.t, constants_).fluence;
            return sum * to_units;
        };
        const double factor =
            alpha_prime_ / (8 * std::numbers::pi * channel_.A * channel_.D);
        const double least = kernel(range_ * range_) * 1e-2;
        const KernelTable table(kernel, mfp_, unit_, std::max(least, 1e-30));
        std::vector<double> H(clusters_.count());
        add(table, factor,
            [&](std::size_t i) {
                return light_.position[i] +
                       float(mfp_) * tangential(light_.w_i[i], light_.normal[i]);
            },
            H);
        return H;
    }

private:
    template <class Position>
    void add(const KernelTable& kernel, double factor, const Position& position,
             std::vector<double>& result) const {
        std::vector<Vec3> positions(flux_.size());
        parallel_for(positions.size(), 16384, [&](std::size_t i) { positions[i] = position(i); });
        const PointSum sum(positions, flux_, light_.nodes, kernel);
        std::vector<float> sums(result.size()), evaluations(result.size());
        sum.evaluate(targets_, kSumTolerance, {sums, evaluations, {}});
        for (std::size_t i = 0; i < result.size(); ++i) result[i] += factor * double(sums[i]);
    }

    const EnteringLight& light_;
    const SurfaceClusters& clusters_;
    double mfp_, alpha_prime_;
    ChannelDiffusion channel_;
    DiffusionConstants constants_;
    double unit_;
    TargetGroups targets_;
    std::vector<float> flux_;
    double range_;
};

}  // namespace

BodyDiffusion::BodyDiffusion(const SampledSurface& samples, const Medium& medium,
                             std::size_t clusters)
    : medium_(medium), clusters_(cluster_surface(samples, clusters)) {
    for (int c = 0; c < 3; ++c) {
        channels_[std::size_t(c)] = channel_diffusion(medium, c);
        operators_[std::size_t(c)].emplace(samples, clusters_, channels_[std::size_t(c)]);
    }
}

ClusterRatio BodyDiffusion::solve(const EnteringLight& light, Report& report) const {
    const std::size_t n = clusters_.count();
    report = {n};
    std::vector<Rgb> B(n), H(n);
    if (light.position.empty()) return {clusters_, std::move(B), std::move(H)};
    for (int c = 0; c < 3; ++c) {
        const ChannelDiffusion& channel = channels_[std::size_t(c)];
        const ClusterSums sums(light, clusters_, reduced_channel(medium_, c), channel, c);
        const std::vector<double> S = sums.in_infinite_medium(), Hs = sums.in_half_space();
        std::vector<double> guess(n);
        for (std::size_t i = 0; i < n; ++i) guess[i] = 2 * channel.A * Hs[i];
        const auto solution = operators_[std::size_t(c)]->solve(S, guess, kSolveTolerance);
        report.iterations = std::max(report.iterations, solution.iterations);
        report.converged = report.converged && solution.converged;
        for (std::size_t i = 0; i < n; ++i) {
            B[i][c] = float(std::max(0.0, solution.phi[i] / (2 * channel.A)));
            H[i][c] = float(Hs[i]);
        }
    }
    if (std::getenv("TALLOW_DEBUG")) {
        Rgb b, h, e; float a = 0;
        for (std::size_t i = 0; i < n; ++i) b += clusters_.area[i] * B[i], h += clusters_.area[i] * H[i], a += clusters_.area[i];
        for (std::size_t i = 0; i < light.area.size(); ++i) e += light.area[i] * light.E_t[i];
        for (int c = 0; c < 3; ++c) std::fprintf(stderr, "c %d E %g B/E %g H/E %g\n", c, double(e[c]), double(b[c]/e[c]), double(h[c]/e[c]));
    }
    return {clusters_, std::move(B), std::move(H)};
}

}  // namespace tallow
