// SPDX-License-Identifier: Apache-2.0
// The half-space itself as a smooth profile.
//
// In: energy per ring from the table, with standard errors. Out: R(r), falling, whose total is that
// of the rings. Everything is done relative to a shape of known integral, diffusion's pair of poles
// with the exact decay of transport, because the ratio q of the two varies slowly:
//
//   1. q = energy of a ring / integral of the shape over it;
//   2. near the centre, where few walks end, q is replaced by a fit of the form that it has there:
//      orders >= 2 grow as -ln r;
//   3. beyond the last ring that is known to 5 %, q is the mean of all that leaves there: transport
//      has become diffusion, and R is q times the shape;
//   4. R at the middles of the rings is made to fall (neighbours that do not are averaged), joined
//      by a monotone cubic in ln R over ln r, and scaled until the rings have their energy.
// clang-format off
#include <math.h>  // before pchip.hpp, which in Boost 1.74 calls a global isnan
#include <boost/math/interpolators/pchip.hpp>
// clang-format on
#include <algorithm>
#include <boost/math/tools/roots.hpp>
#include <numbers>
#include <optional>

#include "common/base/check.h"
#include "common/base/vec.h"
#include "common/optics/profile_models.h"
#include "common/optics/quadrature.h"
#include "common/optics/single_scattering.h"
#include "common/optics/transport_data.h"

namespace tallow {
namespace {

using Grid = TransportGrid;
constexpr double kPiD = std::numbers::pi;

// Decay of the fluence far from all sources, per mean free path: the root of
// alpha' atanh(k) = k for isotropic scattering. Source: [Chan60].
double transport_decay(const ReducedChannel& channel) {
    const double a = channel.absorption;
    if (a < 1e-4) return std::sqrt(3 * a) * (1 - 0.4 * a);  // error below 1e-8
    const auto excess = [&](double k) { return channel.alpha_prime * std::atanh(k) - k; };
    constexpr double kLargest = 1 - 1e-12;  // alpha' below 0.07 decays as the beam itself
    if (excess(kLargest) <= 0) return kLargest;
    std::uintmax_t steps = 100;
    const auto bracket = boost::math::tools::toms748_solve(
        excess, 1e-3, kLargest, boost::math::tools::eps_tolerance<double>(40), steps);
    return bracket.first;
}

// Two poles as in a dipole, decaying as s: sum of z (1 + s d) e^(-s d) / d^3.
struct Shape {
    double z_v, s;

    explicit Shape(const ReducedChannel& channel)
        : z_v(1 + 2 * diffusion_constants(0, channel.eta).z_b), s(transport_decay(channel)) {}
    double at(double r) const { return image_pair(r * r, 1, z_v, s).flux; }
    // Integral over the plane outside of r.
    double beyond(double r) const {
        if (std::isinf(r)) return 0;
        const double d = std::hypot(r, 1.0), d_v = std::hypot(r, z_v);
        return 2 * kPiD * (std::exp(-s * d) / d + z_v * std::exp(-s * d_v) / d_v);
    }
};

double middle(std::size_t ring) {
    return std::sqrt(Grid::outer_radius(int(ring) - 1) * Grid::outer_radius(int(ring)));
}

// Step 2: replaces the ratios q of the rings inside kNoisy by a weighted least-squares fit of
// q = a + b ln r + c r + d r ln r to all rings inside kFitted, ring 0 left out. errors[] are those
// of ratios[]; a ring that no walk has met has neither and is left out of the fit.
void smooth_centre(std::vector<double>& ratios, const std::vector<double>& errors) {
    constexpr double kNoisy = 0.2, kFitted = 0.6;
    const auto basis = [](double r) { return glm::dvec4(1, std::log(r), r, r * std::log(r)); };
    glm::dmat4 normal(0);
    glm::dvec4 right(0);
    for (std::size_t i = 1; middle(i) < kFitted; ++i) {
        if (ratios[i] <= 0) continue;
        const glm::dvec4 f = basis(middle(i));
        const double weight = std::pow(ratios[10] / errors[i], 2);  // of order 1, for conditioning
        normal += weight * glm::outerProduct(f, f);
        right += weight * ratios[i] * f;
    }
    const glm::dvec4 fit = glm::inverse(normal) * right;
    for (std::size_t i = 1; middle(i) < kNoisy; ++i) ratios[i] = glm::dot(fit, basis(middle(i)));
}

// Averages neighbours until the sequence falls ("pool adjacent violators").
void make_falling(std::vector<double>& values) {
    struct Block {
        double mean;
        std::size_t count;
    };
    std::vector<Block> blocks;
    for (const double value : values) {
        blocks.push_back({value, 1});
        while (blocks.size() > 1 && blocks[blocks.size() - 2].mean < blocks.back().mean) {
            const Block b = blocks.back();
            blocks.pop_back();
            Block& a = blocks.back();
            a = {(a.mean * double(a.count) + b.mean * double(b.count)) / double(a.count + b.count),
                 a.count + b.count};
        }
    }
    auto out = values.begin();
    for (const Block& block : blocks) out = std::fill_n(out, block.count, block.mean);
}

using Curve = boost::math::interpolators::pchip<std::vector<double>>;

// ln R over ln r through the middles of rings 1 to size, with a given slope at the last, or as much
// of it as leaves the last piece monotone.
Curve join(const std::vector<double>& values, double last_slope) {
    std::vector<double> x, y;
    for (std::size_t i = 0; i < values.size(); ++i) {
        x.push_back(std::log(middle(i + 1)));
        y.push_back(std::log(values[i]));
    }
    const std::size_t n = x.size();
    const double chord = (y[n - 1] - y[n - 2]) / (x[n - 1] - x[n - 2]);
    const double end_slope = std::max(last_slope, 3 * chord);  // Fritsch and Carlson's bound
    return Curve(std::move(x), std::move(y), 0.0, end_slope);
}

// Orders >= 2, in reduced mean free paths.
class MultipleScattering {
public:
    explicit MultipleScattering(const ReducedChannel& channel) : shape_(channel) {
        const auto rings = transport_rings(channel);
        const std::size_t known = count_known(rings);
        std::vector<double> ratios(known), errors(known);
        for (std::size_t i = 1; i < known; ++i) {
            ratios[i] = rings[i].value / shape_integral(i);
            errors[i] = rings[i].error / shape_integral(i);
        }
        smooth_centre(ratios, errors);
        fit_tail(rings, known);
        fit_curve(ratios);
    }

    double at(double r) const {
        if (r <= middle(1)) return centre_;
        return r < end_ ? std::exp((*curve_)(std::log(r))) : tail_ * shape_.at(r);
    }
    double end() const { return end_; }
    double beyond_end() const { return tail_ * shape_.beyond(end_); }

private:
    double shape_integral(std::size_t ring) const {
        return shape_.beyond(Grid::outer_radius(int(ring) - 1)) -
               shape_.beyond(Grid::outer_radius(int(ring)));
    }

    // Rings before the first one past r = 1 that is not known to 5 %.
    static std::size_t count_known(const std::array<Estimate, Grid::kRings>& rings) {
        std::size_t known = std::size_t(Grid::ring_of(1)) + 1;
        while (known + 1 < rings.size() && rings[known].error < 0.05 * rings[known].value) ++known;
        return known;
    }

    // Step 3. The tail takes over at the middle of the last known ring.
    void fit_tail(const std::array<Estimate, Grid::kRings>& rings, std::size_t known) {
        double energy = 0;
        for (std::size_t i = known - 1; i < rings.size(); ++i) energy += rings[i].value;
        tail_ = energy / shape_.beyond(Grid::outer_radius(int(known) - 2));
        end_ = middle(known - 1);
    }

    // Step 4. R in the middle of a ring is not its mean over the ring: corrected in kRounds rounds.
    void fit_curve(const std::vector<double>& ratios) {
        constexpr int kRounds = 3;
        constexpr double kNudge = 1.001;
        const double slope =
            std::log(shape_.at(end_ * kNudge) / shape_.at(end_ / kNudge)) / (2 * std::log(kNudge));
        std::vector<double> values;
        for (std::size_t i = 1; i + 1 < ratios.size(); ++i)
            values.push_back(ratios[i] * shape_.at(middle(i)));
        values.push_back(tail_ * shape_.at(end_));
        TALLOW_CHECK(values.back() > 0, "a transport tail of {} at {}", values.back(), end_);
        for (int round = 0;; ++round) {
            make_falling(values);
            curve_.emplace(join(values, slope));
            centre_ = values.front();
            tail_ = values.back() / shape_.at(end_);  // changed only where neighbours were averaged
            if (round == kRounds) return;
            for (std::size_t i = 1; i + 1 < ratios.size(); ++i)
                values[i - 1] *= ratios[i] * shape_integral(i) / curve_integral(i);
        }
    }

    double curve_integral(std::size_t ring) const {
        const double low = Grid::outer_radius(int(ring) - 1), high = Grid::outer_radius(int(ring));
        return 2 * kPiD * integrate_log(low, high, 0.02, [this](double r) { return r * at(r); });
    }

    Shape shape_;
    double tail_ = 0, end_ = 0, centre_ = 0;
    std::optional<Curve> curve_;
};

class TransportProfile final : public ReducedProfile {
public:
    TransportProfile(const ReducedChannel& channel, Orders orders)
        : ReducedProfile(channel.sigma_t_prime),
          multiple_(channel),
          alpha_(channel.alpha_prime),
          eta_(channel.eta),
          with_first_(orders == Orders::all) {
        total_ = multiple_.beyond_end() +
                 2 * kPiD * integrate_log(kInnermost, multiple_.end(), 0.02, [this](double r) {
                     return r * (multiple_.at(r) + first(r));
                 });
    }

    double reduced(double r2) const override {
        const double r = softened(r2);
        return multiple_.at(r) + first(r);
    }
    double total_reflectance() const override { return total_; }

private:
    // The first order, if it is wanted. What of it leaves past the end of the curve is nothing.
    double first(double r) const {
        return with_first_ ? single_scattering_profile(alpha_, eta_, r) : 0;
    }

    MultipleScattering multiple_;
    double alpha_, eta_;
    bool with_first_;
    double total_ = 0;
};

}  // namespace

std::unique_ptr<Profile> transport_profile(const ReducedChannel& channel, Orders orders) {
    return std::make_unique<TransportProfile>(channel, orders);
}

}  // namespace tallow
