// SPDX-License-Identifier: Apache-2.0
// Flights back from clusters -> places on them -> fluence there, of sources and of the surface's
// layers -> radiance that leaves.
#include "common/diffusion/leaving_ways.h"

#include <algorithm>
#include <cmath>

#include "common/base/parallel.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

// The layers' fluence is smooth up to the surface, where it is known: it is summed at the last
// nodes of each way only, and the others lie on a parabola. 4 sums at all of them, for comparison
// (docs/BODY_AWARE.md).
constexpr std::size_t kSummed = 2;

constexpr std::size_t kPointsOfCluster = LeavingRays::kDirections * kSummed;
constexpr std::size_t kClustersOfPacket = PointPacket::kSize / kPointsOfCluster;
static_assert(kClustersOfPacket * kPointsOfCluster == PointPacket::kSize);

// Where light goes no farther than this part of a mean free path its fluence is that at the
// surface.
constexpr float kNoWay = 1e-3f;

// Through (0, f), (a, of_a) and (b, of_b), at x; 0 < a < b.
double parabola(double f, double a, double of_a, double b, double of_b, double x) {
    return f * (x - a) * (x - b) / (a * b) + of_a * x * (x - b) / (a * (a - b)) +
           of_b * x * (x - a) / (b * (b - a));
}

}  // namespace

LeavingWays::LeavingWays(std::span<const Vec3> positions, std::span<const Vec3> normals,
                         const FollowFlights& follow, float longest)
    : position_(positions.begin(), positions.end()),
      normal_(normals.begin(), normals.end()),
      longest_(longest) {
    std::vector<Vec3> from, normal, w;
    for (std::size_t i = 0; i < position_.size(); ++i)
        for (std::size_t d = 0; d < kDirections; ++d) {
            from.push_back(position_[i]), normal.push_back(normal_[i]);
            w.push_back(-LeavingRays(normal_[i]).direction(d));
        }
    back_ = follow(from, normal, w, longest);
}

std::vector<LeavingPlace> LeavingWays::places() const {
    std::vector<LeavingPlace> places(position_.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
        std::array<float, kDirections> lengths{};
        for (std::size_t d = 0; d < kDirections; ++d)
            lengths[d] = std::min(longest_, back_[i * kDirections + d].legs[0].length);
        places[i] = {position_[i], normal_[i], LeavingRays(normal_[i]).fit(lengths)};
    }
    return places;
}

Collisions LeavingWays::collisions(std::size_t cluster, std::size_t direction,
                                   double mean_free_path) const {
    return {back_[cluster * kDirections + direction], mean_free_path};
}

std::vector<LeavingWays::Nodes> LeavingWays::place_nodes(const DecayRule<kNodes>& rule,
                                                         double mean_free_path) const {
    std::vector<Nodes> nodes(position_.size());
    parallel_for(nodes.size(), 64, [&](std::size_t i) {
        for (std::size_t d = 0; d < kDirections; ++d) {
            const Collisions on_way = collisions(i, d, mean_free_path);
            nodes[i].probability[d] = on_way.probability();
            for (std::size_t k = 0; k < kNodes; ++k) {
                const Vec3 way = on_way.at(rule.share_on(k, on_way.length()));
                nodes[i].place[d][k] = position_[i] + way;
                nodes[i].distance[d][k] = glm::length(way);
            }
        }
    });
    return nodes;
}

std::vector<LeavingWays::Fluence> LeavingWays::of_sources(const SolvedChannel& solved,
                                                          std::span<const Nodes> nodes) const {
    constexpr std::size_t kPoints = kDirections * kNodes;
    std::vector<Vec3> points(nodes.size() * kPoints);
    std::vector<std::int64_t> own(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i] = nodes[i / kPoints].place[i % kPoints / kNodes][i % kNodes];
        own[i] = solved.own_sample[i / kPoints];
    }
    const std::vector<double> sums = solved.sources.inside(points, own);
    std::vector<Fluence> fluence(nodes.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        fluence[i / kPoints][i % kPoints / kNodes][i % kNodes] = sums[i];
    return fluence;
}

// Of light that scattered once more, in Grosjean's parts: alpha' times that of the solution.
std::vector<LeavingWays::Fluence> LeavingWays::of_layers(const SolvedChannel& solved,
                                                         std::span<const Nodes> nodes) const {
    constexpr std::size_t kFirst = kNodes - kSummed;
    const std::size_t n = nodes.size();
    const double alpha_prime = solved.kernels.reduced.alpha_prime;
    const float mean_free_path = float(1 / solved.kernels.reduced.sigma_t_prime);
    std::vector<float> phi(n);
    for (std::size_t i = 0; i < n; ++i) phi[i] = float(alpha_prime * solved.phi[i]);
    const auto lane = [](std::size_t i, std::size_t d, std::size_t k) {
        return (i % kClustersOfPacket * kDirections + d) * kSummed + k - kFirst;
    };
    std::vector<PointPacket> packets((n + kClustersOfPacket - 1) / kClustersOfPacket);
    for (std::size_t i = 0; i < packets.size() * kClustersOfPacket; ++i)
        for (std::size_t d = 0; d < kDirections; ++d)
            for (std::size_t k = kFirst; k < kNodes; ++k)
                packets[i / kClustersOfPacket].set(int(lane(i, d, k)),
                                                   nodes[std::min(i, n - 1)].place[d][k]);
    const std::vector<SurfaceSum> sums =
        solved.equation.sum_layers(solved.samples, solved.tree, solved.channel, phi, packets);

    std::vector<Fluence> fluence(n);
    parallel_for(n, 64, [&](std::size_t i) {
        const SurfaceSum& sum = sums[i / kClustersOfPacket];
        const double at_surface = alpha_prime * (solved.phi[i] - solved.S[i]);
        for (std::size_t d = 0; d < kDirections; ++d) {
            std::array<double, kNodes>& on_way = fluence[i][d];
            // What the layers' quadrature misses of the solid angle near the surface has the
            // fluence of the cluster there.
            for (std::size_t k = kFirst; k < kNodes; ++k)
                on_way[k] = double(phi[i]) * (1 - double(sum.solid_angle.of[lane(i, d, k)])) -
                            double(sum.layers.of[lane(i, d, k)]);
            const std::array<float, kNodes>& t = nodes[i].distance[d];
            const bool is_way = t[kFirst] > kNoWay * mean_free_path && t[kFirst + 1] > t[kFirst];
            for (std::size_t k = 0; k < kFirst; ++k)
                on_way[k] = is_way
                                ? parabola(at_surface, double(t[kFirst]), on_way[kFirst],
                                           double(t[kFirst + 1]), on_way[kFirst + 1], double(t[k]))
                                : at_surface;
        }
    });
    return fluence;
}

std::vector<LeavingRadiance> LeavingWays::radiance(const SolvedChannel& solved) const {
    const ReducedChannel& reduced = solved.kernels.reduced;
    const double factor = diffuse_fresnel_transmittance(reduced.eta) /
                          (4 * reduced.eta * reduced.eta) * reduced.alpha_prime;
    const auto rule = last_scattering_rule(solved.kernels.kappa);
    const std::vector<Nodes> nodes = place_nodes(rule, 1 / reduced.sigma_t_prime);
    const std::vector<Fluence> sources = of_sources(solved, nodes),
                               layers = of_layers(solved, nodes);
    std::vector<LeavingRadiance> radiance(nodes.size());
    parallel_for(nodes.size(), 64, [&](std::size_t i) {
        std::array<float, kDirections> X{};
        for (std::size_t d = 0; d < kDirections; ++d) {
            double sum = 0;
            for (std::size_t k = 0; k < kNodes; ++k)
                sum += rule.weight[k] * std::max(0.0, sources[i][d][k] + layers[i][d][k]);
            X[d] = float(factor * nodes[i].probability[d] * sum);
        }
        radiance[i] = LeavingRays(normal_[i]).fit(X);
    });
    return radiance;
}

LeavingRadiance LeavingWays::of_even_fluence(std::size_t cluster, double mean_free_path) const {
    constexpr float kLeast = 1e-4f;
    std::array<float, kDirections> scattered{};
    for (std::size_t d = 0; d < kDirections; ++d)
        scattered[d] =
            std::max(kLeast, float(collisions(cluster, d, mean_free_path).probability()));
    return LeavingRays(normal_[cluster]).fit(scattered);
}

}  // namespace tallow
