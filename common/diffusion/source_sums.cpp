// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/source_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/base/parallel.h"
#include "common/diffusion/leaving_radiance.h"
#include "common/diffusion/light_balance.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

// Chosen: a half of what the size of clusters leaves (docs/BODY_AWARE.md).
constexpr float kSumTolerance = 1e-2f;

// Of the distance from a source in an infinite medium, mean free paths; well below the first depth.
constexpr double kSoftening = 0.02;

// The same at points inside, which may come as near to a source as they like.
constexpr double kSofteningInside = 0.15;

// A sample that is as near as its own cell is wide does not act as a point: its cell is summed over
// so many points instead.
constexpr int kCellPoints = 32;

// Farther away than so many areas of its cell (squared) it acts as a point: within 1 % of itself.
constexpr float kFarFromCell = 9;

// Mean cosine inside of ways on which light leaves.
constexpr double kMeanCosine = 0.85;

Vec3 tangential(Vec3 w, Vec3 n) { return w - glm::dot(w, n) * n; }

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

/// Depths at which the half-space's fluence is known, mean free paths, and what it counts in the
/// exitance: the integral of F_t(mu) alpha' / (2 eta^2) W(mu') mu dmu. Those of the ways out of a
/// body, at their mean cosine, so that both miss the same.
struct HalfSpaceNodes {
    std::array<double, 4> z, weight;
};

HalfSpaceNodes half_space_nodes(double alpha_prime, double eta, double kappa) {
    constexpr int kSteps = 200;
    HalfSpaceNodes nodes{};
    const auto rule = last_scattering_rule(kappa);
    for (std::size_t k = 0; k < nodes.z.size(); ++k) nodes.z[k] = kMeanCosine * rule.depth(k);
    for (int i = 0; i < kSteps; ++i) {
        const double mu = (i + 0.5) / kSteps;
        const double inside = std::sqrt(1 - (1 - mu * mu) / (eta * eta));
        const auto along = decay_weights(nodes.z, inside);
        const double T = double(fresnel_transmittance(float(eta), float(mu)));
        for (std::size_t k = 0; k < along.size(); ++k)
            nodes.weight[k] += T * alpha_prime / (2 * eta * eta) * along[k] * mu / kSteps;
    }
    return nodes;
}

// 4 pi D times the fluence at depth z of a source at depth t, as SourceKernels::inside has it; all
// in mean free paths. Of light on its way the part that the surface mirrors is left out in both.
double fluence_in_half_space(double r2, double t, double z, double alpha_prime,
                             const DiffusionConstants& k) {
    constexpr double kSoft2 = kSofteningInside * kSofteningInside;
    const double near2 = r2 + (t - z) * (t - z) + kSoft2, near = std::sqrt(near2);
    double diffuse = half_space_fluence(r2, t + z, k);
    const double far = std::sqrt(r2 + (t + z) * (t + z));
    diffuse += std::exp(-k.s * near) / near - std::exp(-k.s * far) / far;
    return alpha_prime * diffuse + k.D * std::exp(-near) / near2;
}

// Of the tables, an order below that of the sums: finer ones take longer to make than to use.
constexpr double kTableError = 5e-4;

double kappa_of(const ReducedChannel& reduced) {
    return diffusion_constants(reduced.absorption, reduced.eta).s;
}

KernelTable tabulate(const auto& kernel, double unit, double mfp, double range) {
    return {kernel, mfp, unit, std::max(kernel(range * range) * 1e-2, 1e-30), kTableError};
}

KernelTable tabulate_infinite(const ChannelDiffusion& k, double unit, double mfp, double range) {
    const auto kernel = [&](double r2) {
        const double d = std::sqrt(r2 + kSoftening * kSoftening * mfp * mfp);
        return std::exp(-k.s * d) / d;
    };
    return tabulate(kernel, unit, mfp, range);
}

KernelTable tabulate_inside(const ChannelDiffusion& k, double alpha_prime, double unit, double mfp,
                            double range) {
    const auto kernel = [&](double r2) {
        const double d = std::sqrt(r2 + kSofteningInside * kSofteningInside * mfp * mfp);
        return alpha_prime * std::exp(-k.s * d) / d + k.D * std::exp(-d / mfp) / (d * d);
    };
    return tabulate(kernel, unit, mfp, range);
}

KernelTable tabulate_on_its_way(const ChannelDiffusion& k, double unit, double mfp, double range) {
    const auto kernel = [&](double r2) {
        const double u = r2 + kSoftening * kSoftening * mfp * mfp;
        return k.D * std::exp(-std::sqrt(u) / mfp) / u;
    };
    return tabulate(kernel, unit, mfp, range);
}

// Of all depths of sources in a half-space; `at_depth(r2, t)` in mean free paths, times 4 pi D.
KernelTable tabulate_all_depths(const ReducedChannel& reduced, double unit, double range,
                                const auto& at_depth) {
    const double sigma = reduced.sigma_t_prime;
    const auto depths = first_scattering_rule(kappa_of(reduced));
    const auto kernel = [&](double r2) {
        double sum = 0;
        for (std::size_t i = 0; i < depths.weight.size(); ++i)
            sum += depths.weight[i] * at_depth(r2 * sigma * sigma, depths.depth(i));
        return sum * sigma;
    };
    return tabulate(kernel, unit, 1 / sigma, range);
}

KernelTable tabulate_leaving_diffusion(const ReducedChannel& reduced, double unit, double range) {
    const DiffusionConstants k = diffusion_constants(reduced.absorption, reduced.eta);
    return tabulate_all_depths(reduced, unit, range, [&](double r2, double t) {
        return half_space_fluence(r2, t, k) / (2 * k.A);
    });
}

KernelTable tabulate_on_its_way_out(const ReducedChannel& reduced, double unit, double range) {
    const DiffusionConstants k = diffusion_constants(reduced.absorption, reduced.eta);
    return tabulate_all_depths(reduced, unit, range, [&](double r2, double t) {
        const double z = t + LightBalance::kAbove;
        const double u = r2 + z * z;
        return k.D * std::exp(-std::sqrt(u)) / u;
    });
}

KernelTable tabulate_leaving(const ReducedChannel& reduced, double unit, double range) {
    const DiffusionConstants k = diffusion_constants(reduced.absorption, reduced.eta);
    const HalfSpaceNodes nodes = half_space_nodes(reduced.alpha_prime, reduced.eta, k.s);
    const auto depths = first_scattering_rule(k.s);
    const auto kernel = [&](double r2) {
        const double u = r2 * reduced.sigma_t_prime * reduced.sigma_t_prime;
        double sum = 0;
        for (std::size_t i = 0; i < depths.weight.size(); ++i)
            for (std::size_t n = 0; n < nodes.z.size(); ++n)
                sum +=
                    depths.weight[i] * nodes.weight[n] *
                    fluence_in_half_space(u, depths.depth(i), nodes.z[n], reduced.alpha_prime, k);
        return sum * reduced.sigma_t_prime;
    };
    return tabulate(kernel, unit, 1 / reduced.sigma_t_prime, range);
}

}  // namespace

SourceKernels::SourceKernels(const ReducedChannel& reduced, const ChannelDiffusion& channel,
                             double range)
    : unit(KernelTable::unit_near(1 / reduced.sigma_t_prime)),
      kappa(kappa_of(reduced)),
      depths(first_scattering_rule(kappa)),
      factor(reduced.alpha_prime / (4 * std::numbers::pi * channel.D)),
      in_infinite_medium(tabulate_infinite(channel, unit, 1 / reduced.sigma_t_prime, range)),
      inside(tabulate_inside(channel, reduced.alpha_prime, unit, 1 / reduced.sigma_t_prime, range)),
      on_its_way(tabulate_on_its_way(channel, unit, 1 / reduced.sigma_t_prime, range)),
      leaving(tabulate_leaving(reduced, unit, range)),
      leaving_diffusion(tabulate_leaving_diffusion(reduced, unit, range)),
      on_its_way_out(tabulate_on_its_way_out(reduced, unit, range)) {}

SourceSums::SourceSums(const EnteringLight& light, const SourceKernels& kernels,
                       double mean_free_path, int c)
    : light_(light),
      kernels_(kernels),
      mfp_(mean_free_path),
      c_(c),
      on_flights_(sources(kernels.in_infinite_medium, kernels.depths.weight.size(),
                          [&](std::size_t i, std::size_t k) { return on_flight(i, k); })),
      on_surface_(
          sources(kernels.leaving, 1, [&](std::size_t i, std::size_t) { return on_surface(i); })) {}

std::vector<double> SourceSums::on_flights(const KernelTable& kernel, std::span<const Vec3> places,
                                           std::span<const std::int64_t> own_sample) const {
    return sum({on_flights_, kernel}, places, own_sample, kernels_.depths.weight.size(),
               [&](std::size_t i, std::size_t k) { return on_flight(i, k); });
}

std::vector<double> SourceSums::on_surface(const KernelTable& kernel, std::span<const Vec3> places,
                                           std::span<const std::int64_t> own_sample) const {
    return sum({on_surface_, kernel}, places, own_sample, 1,
               [&](std::size_t i, std::size_t) { return on_surface(i); });
}

std::vector<double> SourceSums::in_infinite_medium(std::span<const Vec3> places,
                                                   std::span<const std::int64_t> own_sample) const {
    return on_flights(kernels_.in_infinite_medium, places, own_sample);
}

std::vector<double> SourceSums::inside(std::span<const Vec3> points,
                                       std::span<const std::int64_t> own_sample) const {
    return on_flights(kernels_.inside, points, own_sample);
}

std::vector<double> SourceSums::on_its_way_out(std::span<const Vec3> places,
                                               std::span<const Vec3> normals) const {
    std::vector<Vec3> above(places.size());
    for (std::size_t i = 0; i < above.size(); ++i)
        above[i] = places[i] + float(LightBalance::kAbove * mfp_) * normals[i];
    return on_flights(kernels_.on_its_way, above, std::vector<std::int64_t>(above.size(), -1));
}

std::vector<double> SourceSums::leaving_half_space(std::span<const Vec3> places,
                                                   std::span<const std::int64_t> own_sample) const {
    return on_surface(kernels_.leaving, places, own_sample);
}

std::vector<double> SourceSums::diffusion_leaving_half_space(
    std::span<const Vec3> places, std::span<const std::int64_t> own_sample) const {
    return on_surface(kernels_.leaving_diffusion, places, own_sample);
}

std::vector<double> SourceSums::on_its_way_out_of_half_space(
    std::span<const Vec3> places, std::span<const std::int64_t> own_sample) const {
    return on_surface(kernels_.on_its_way_out, places, own_sample);
}

SourceSums::Source SourceSums::on_flight(std::size_t i, std::size_t depth) const {
    const auto weight = float(kernels_.depths.weight[depth]);
    const Flight& flight = light_.flights[i];
    if (double(flight.legs[0].length) >= kLongestFlight * mfp_)
        return {float(kernels_.depths.depth(depth) * mfp_) * light_.w_i[i], weight};
    const Collisions collisions(flight, mfp_);
    return {collisions.at(kernels_.depths.share_on(depth, collisions.length())),
            weight * float(collisions.probability())};
}

// Depths are in the half-space's kernel; what is left of the beam is its way along the surface.
SourceSums::Source SourceSums::on_surface(std::size_t i) const {
    return {float(mfp_) * tangential(light_.w_i[i], light_.normal[i]), 1};
}

// Of the flux of samples, each of which acts at `sources` points as source(sample, k) says. All are
// points of one tree: from afar they act together.
template <class SourceOf>
PointSum SourceSums::sources(const KernelTable& kernel, std::size_t sources,
                             const SourceOf& source) const {
    const std::size_t n = light_.area.size();
    std::vector<Vec3> positions(sources * n);
    std::vector<float> flux(sources * n);
    parallel_for(n, 4096, [&](std::size_t i) {
        for (std::size_t k = 0; k < sources; ++k) {
            const Source at = source(i, k);
            positions[i * sources + k] = light_.position[i] + at.offset;
            flux[i * sources + k] = at.share * light_.area[i] * light_.E_t[i][c_];
        }
    });
    std::vector<OctreeNode> nodes(light_.nodes.begin(), light_.nodes.end());
    for (OctreeNode& node : nodes)
        node.first *= std::uint32_t(sources), node.count *= std::uint32_t(sources);
    return {positions, flux, nodes, kernel};
}

// [place] of the sum, with cells in the place of samples that are near.
template <class SourceOf>
std::vector<double> SourceSums::sum(const PointSum& point_sum, std::span<const Vec3> places,
                                    std::span<const std::int64_t> own_sample, std::size_t sources,
                                    const SourceOf& source) const {
    std::vector<float> sums(places.size()), evaluations(places.size());
    point_sum.evaluate(TargetGroups(places, kernels_.unit), kSumTolerance, {sums, evaluations, {}});
    std::vector<double> result(sums.size());
    parallel_for(result.size(), 64, [&](std::size_t i) {
        const double own = own_sample[i] < 0 ? 0
                                             : own_cell(places[i], std::size_t(own_sample[i]),
                                                        point_sum.kernel(), sources, source);
        // Where samples are far apart, what is taken off for the own cell is rounding at best.
        result[i] = kernels_.factor * std::max(0.0, double(sums[i]) + own);
    });
    return result;
}

// What the cell of a sample sends to a place near it beyond what it does as points.
template <class SourceOf>
double SourceSums::own_cell(Vec3 place, std::size_t sample, const KernelTable& kernel,
                            std::size_t sources, const SourceOf& source) const {
    const Cell cell(light_.normal[sample], light_.area[sample]);
    const Vec3 to_sample = light_.position[sample] - place;
    double sum = 0;
    for (std::size_t p = 0; p < sources; ++p) {
        const Source at = source(sample, p);
        const Vec3 d = to_sample + at.offset;
        if (length2(d) > kFarFromCell * light_.area[sample]) continue;
        double mean = 0;
        for (int k = 0; k < kCellPoints; ++k)
            mean += double(kernel(length2(d + cell.point(k)))) / kCellPoints;
        sum += double(at.share) * (mean - double(kernel(length2(d))));
    }
    return double(light_.area[sample] * light_.E_t[sample][c_]) * sum;
}

}  // namespace tallow
