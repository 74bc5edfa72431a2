// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/source_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/base/parallel.h"
#include "common/diffusion/leaving_radiance.h"
#include "common/diffusion/light_balance.h"
#include "common/diffusion/sunflower.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

// Chosen: a third of what the size of clusters leaves (docs/BODY_AWARE.md).
constexpr float kSumTolerance = 7e-3f;

// Of the distance from a source in an infinite medium, mean free paths; well below the first depth.
constexpr double kSoftening = 0.02;

// The same at points inside, which may come as near to a source as they like.
constexpr double kSofteningInside = 0.15;

// A sample that is as near as its own cell is wide does not act as a point: its cell is summed over
// so many points instead.
constexpr int kCellPoints = 32;

// Farther away than so many areas of its cell (squared) it acts as a point: within 1 % of itself.
constexpr float kFarFromCell = 9;

// Nodes whose area is so many squares of the mean free path and less have layers of their own:
// they are about as wide then as sources lie deep. Measured on the bunny: 1 to 25 are alike.
constexpr double kSplitArea = 9;

// Height above a half-space, mean free paths, at which the fluence of light that scattered once
// says how much of it leaves there. It is a smooth function of the distance along the surface, in
// which samples do not show; together it is as much as leaves. Of a body LeavingOnce adds up what
// does.
constexpr double kAbove = 0.5;

// Mean cosine inside of ways on which light leaves.
constexpr double kMeanCosine = 0.85;

Vec3 tangential(Vec3 w, Vec3 n) { return w - glm::dot(w, n) * n; }

// A cell of the radius 1.
const std::array<Vec2, kCellPoints> kDisc = [] {
    std::array<Vec2, kCellPoints> points;
    for (int k = 0; k < kCellPoints; ++k) points[std::size_t(k)] = sunflower_point(k, kCellPoints);
    return points;
}();

/// Mean of a kernel over a disc of a sample's area in its tangent plane, at `d` from its middle.
class Cell {
public:
    Cell(Vec3 normal, float area) {
        const float radius = std::sqrt(area / std::numbers::pi_v<float>);
        const Frame frame = make_frame(normal);
        s_ = radius * frame.s, t_ = radius * frame.t;
    }
    double mean(const KernelTable& kernel, Vec3 d) const {
        double sum = 0;
        for (const Vec2& p : kDisc) sum += double(kernel(length2(d + p.x * s_ + p.y * t_)));
        return sum / kCellPoints;
    }

private:
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

// Of the tables, a third of that of the sums: finer ones take longer to make than to use.
constexpr double kTableError = 2e-3;

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

// Of a half-space whose light entered under the cosine mu_0 inside, with mu that of what leaves:
//
//     leaving = integral of T mu / (mu + mu_0),   phi_1 = integral of e^(-above / mu) / (mu + mu_0)
double leaving_once_by_fluence(double eta) {
    constexpr int kSteps = 2000;    // of the midpoint rule
    constexpr double kEntry = 0.9;  // mu_0; refraction leaves no cosine below 0.64
    double leaving = 0, phi_1 = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double mu = (i + 0.5) / kSteps;
        leaving += double(fresnel_transmittance(float(1 / eta), float(mu))) * mu / (mu + kEntry);
        phi_1 += std::exp(-kAbove / mu) / (mu + kEntry);
    }
    return leaving / phi_1;
}

// Of all depths of sources in a half-space.
KernelTable tabulate_leaving(const ReducedChannel& reduced, const LightBalance& balance,
                             double unit, double range) {
    const double sigma = reduced.sigma_t_prime;
    const DiffusionConstants k = diffusion_constants(reduced.absorption, reduced.eta);
    const HalfSpaceNodes nodes = half_space_nodes(reduced.alpha_prime, reduced.eta, k.s);
    const auto depths = first_scattering_rule(k.s);
    const double once = leaving_once_by_fluence(reduced.eta);
    // Times 4 pi D, lengths in mean free paths.
    const auto from_depth = [&](double r2, double t) {
        const double above = t + kAbove, u = r2 + above * above;
        double by_last_flight = 0;
        for (std::size_t n = 0; n < nodes.z.size(); ++n)
            by_last_flight +=
                nodes.weight[n] * fluence_in_half_space(r2, t, nodes.z[n], reduced.alpha_prime, k);
        return balance.leaving(half_space_fluence(r2, t, k) / (2 * k.A),
                               once * k.D * std::exp(-std::sqrt(u)) / u, by_last_flight);
    };
    const auto kernel = [&](double r2) {
        double sum = 0;
        for (std::size_t i = 0; i < depths.weight.size(); ++i)
            sum += depths.weight[i] * from_depth(r2 * sigma * sigma, depths.depth(i));
        return sum * sigma;
    };
    return tabulate(kernel, unit, 1 / sigma, range);
}

std::array<double, 5> depths_of(const DecayRule<5>& rule) {
    std::array<double, 5> depths{};
    for (std::size_t k = 0; k < depths.size(); ++k) depths[k] = rule.depth(k);
    return depths;
}

}  // namespace

SourceKernels::SourceKernels(const ReducedChannel& of, const ChannelDiffusion& channel,
                             const LightBalance& balance, double range)
    : reduced(of),
      unit(KernelTable::unit_near(1 / reduced.sigma_t_prime)),
      kappa(kappa_of(reduced)),
      depths(first_scattering_rule(kappa)),
      depth(depths_of(depths)),
      factor(reduced.alpha_prime / (4 * std::numbers::pi * channel.D)),
      in_infinite_medium(tabulate_infinite(channel, unit, 1 / reduced.sigma_t_prime, range)),
      inside(tabulate_inside(channel, reduced.alpha_prime, unit, 1 / reduced.sigma_t_prime, range)),
      leaving(tabulate_leaving(reduced, balance, unit, range)) {}

SourceSums::SourceSums(const EnteringLight& light, const SourceKernels& kernels,
                       double mean_free_path, int c)
    : light_(light),
      kernels_(kernels),
      mfp_(mean_free_path),
      c_(c),
      on_flights_(make_sources(kernels.in_infinite_medium,
                               std::uint32_t(kernels.depths.weight.size()),
                               [&](std::size_t i, auto&& add) { put_on_flight(i, add); })),
      on_surface_(make_sources(kernels.leaving, 1,
                               [&](std::size_t i, auto&& add) { put_on_surface(i, add); })) {}

std::vector<double> SourceSums::in_infinite_medium(std::span<const Vec3> places,
                                                   std::span<const std::int64_t> own_sample) const {
    return sum(on_flights_, kernels_.in_infinite_medium, places, own_sample);
}

std::vector<double> SourceSums::inside(std::span<const Vec3> points,
                                       std::span<const std::int64_t> own_sample) const {
    return sum(on_flights_, kernels_.inside, points, own_sample);
}

std::vector<LeavingOnce::Exitance> SourceSums::leaving_once(
    std::span<const LeavingPlace> places) const {
    double area = 0;
    for (const float a : light_.area) area += double(a);
    const LeavingOnce once(kernels_.reduced, on_flights_.sum.tree(),
                           area / double(light_.area.size()), first_order_on_flights());
    std::vector<LeavingOnce::Exitance> result(places.size());
    parallel_ranges(result.size(), 16, [&](std::size_t begin, std::size_t end) {
        OnceSources near;
        for (std::size_t i = begin; i < end; ++i) result[i] = once.at(places[i], near);
    });
    return result;
}

// [source] flux.
std::vector<float> SourceSums::first_order_on_flights() const {
    if (light_.first_order.empty()) return {};
    std::vector<float> flux(on_flights_.nodes.size());
    parallel_for(light_.area.size(), 4096, [&](std::size_t i) {
        put_on_flight(i, [&](std::size_t layer, Vec3, double share) {
            flux[on_flights_.nodes.point(i, std::uint32_t(layer))] =
                float(share) * light_.area[i] * light_.first_order[i][c_];
        });
    });
    return flux;
}

std::vector<double> SourceSums::leaving_half_space(std::span<const Vec3> places,
                                                   std::span<const std::int64_t> own_sample) const {
    return sum(on_surface_, kernels_.leaving, places, own_sample);
}

template <class Add>
void SourceSums::put_on_flight(std::size_t i, const Add& add) const {
    const DecayRule<5>& depths = kernels_.depths;
    const Flight& flight = light_.flights[i];
    if (double(flight.legs[0].length) >= kLongestFlight * mfp_) {
        for (std::size_t k = 0; k < depths.weight.size(); ++k)
            add(k, float(kernels_.depth[k] * mfp_) * light_.w_i[i], depths.weight[k]);
        return;
    }
    // Light from many directions goes less far along their mean, which is shorter than 1.
    const double along = std::max(0.1, double(glm::length(light_.w_i[i])));
    const Collisions collisions(flight, along * mfp_);
    for (std::size_t k = 0; k < depths.weight.size(); ++k)
        add(k, collisions.at(depths.share_on(k, collisions.length())),
            depths.weight[k] * collisions.probability());
}

// Depths are in the half-space's kernel; what is left of the beam is its way along the surface.
template <class Add>
void SourceSums::put_on_surface(std::size_t i, const Add& add) const {
    add(0, float(mfp_) * tangential(light_.w_i[i], light_.normal[i]), 1);
}

// Of the flux of samples, each of which acts in `layers` points: put(sample, add) calls add(layer,
// offset from the sample in mm, share of the flux) for each. All are points of one tree: from afar
// they act together.
template <class Put>
SourceSums::Sources SourceSums::make_sources(const KernelTable& kernel, std::uint32_t layers,
                                             const Put& put) const {
    LayeredNodes nodes(light_.nodes, light_.area, layers, kSplitArea * mfp_ * mfp_);
    std::vector<Vec3> positions(nodes.size());
    std::vector<float> flux(nodes.size());
    parallel_for(light_.area.size(), 4096, [&](std::size_t i) {
        put(i, [&](std::size_t layer, Vec3 offset, double share) {
            const std::size_t p = nodes.point(i, std::uint32_t(layer));
            positions[p] = light_.position[i] + offset;
            flux[p] = float(share) * light_.area[i] * light_.E_t[i][c_];
        });
    });
    PointSum sum(positions, flux, nodes.nodes(), kernel);
    return {std::move(nodes), std::move(sum)};
}

// [place] of the sum, with cells in the place of samples that are near.
std::vector<double> SourceSums::sum(const Sources& sources, const KernelTable& kernel,
                                    std::span<const Vec3> places,
                                    std::span<const std::int64_t> own_sample) const {
    const PointSum point_sum(sources.sum, kernel);
    std::vector<float> sums(places.size()), evaluations(places.size());
    point_sum.evaluate(TargetGroups(places, kernels_.unit), kSumTolerance, {sums, evaluations, {}});
    std::vector<double> result(sums.size());
    parallel_for(result.size(), 64, [&](std::size_t i) {
        const double own = own_sample[i] < 0
                               ? 0
                               : own_cell(sources, kernel, places[i], std::size_t(own_sample[i]));
        // Where samples are far apart, what is taken off for the own cell is rounding at best.
        result[i] = kernels_.factor * std::max(0.0, double(sums[i]) + own);
    });
    return result;
}

// What the cell of a sample sends to a place near it beyond what it does as points.
double SourceSums::own_cell(const Sources& sources, const KernelTable& kernel, Vec3 place,
                            std::size_t sample) const {
    const Cell cell(light_.normal[sample], light_.area[sample]);
    const SumTree& tree = sources.sum.tree();
    double sum = 0;
    for (std::uint32_t k = 0; k < sources.nodes.layers(); ++k) {
        const SumTree::Point& source = tree.points()[sources.nodes.point(sample, k)];
        const Vec3 d = float(tree.unit()) * Vec3(source.x, source.y, source.z) - place;
        if (length2(d) > kFarFromCell * light_.area[sample]) continue;
        sum += double(source.weight) * (cell.mean(kernel, d) - double(kernel(length2(d))));
    }
    return tree.weight_scale() * sum;
}

}  // namespace tallow
