// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/flight.h"

#include <algorithm>
#include <cmath>

namespace tallow {
namespace {

// A last node that makes the rule exact for e^(kappa t) on a way of `length`.
template <std::size_t N>
double last_share(const DecayRule<N>& rule, double length) {
    const double all = -std::expm1(-length);
    double rest = -std::expm1(-(1 - rule.kappa) * length) / (1 - rule.kappa);
    for (std::size_t k = 0; k + 1 < N; ++k)
        rest -= all * rule.weight[k] * std::pow(1 - rule.share[k] * all, -rule.kappa);
    const double decayed = std::pow(rest / (all * rule.weight[N - 1]), -1 / rule.kappa);  // e^-t
    return std::clamp((1 - decayed) / all, rule.share[N - 2], 1 - 1e-9);
}

template <std::size_t N>
DecayRule<N> make_rule(double kappa, std::array<double, N> share, std::array<double, N> weight) {
    DecayRule<N> rule{std::clamp(kappa, 1e-3, 0.95), share, weight};
    rule.share[N - 1] = last_share(rule, kLongestFlight * 10);
    return rule;
}

}  // namespace

template <std::size_t N>
double DecayRule<N>::share_on(std::size_t k, double length) const {
    return k + 1 < N || !(length < kLongestFlight) ? share[k] : last_share(*this, length);
}

template struct DecayRule<4>;
template struct DecayRule<5>;

// The first nodes are close enough to the surface for what leaves near by.
DecayRule<5> first_scattering_rule(double kappa) {
    return make_rule<5>(kappa, {.05833, .23003, .44998, .68633, 0}, {.12, .22, .24, .24, .18});
}

// But for its last node the rule of Gauss.
DecayRule<4> last_scattering_rule(double kappa) {
    return make_rule<4>(kappa, {.0694318, .3300095, .6699905, 0},
                        {.1739274, .3260726, .3260726, .1739274});
}

Collisions::Collisions(const Flight& flight, double mean_free_path)
    : flight_(flight), mean_free_path_(mean_free_path) {
    double before = 0;  // ways of the legs until here
    for (std::size_t i = 0; i < Flight::kLegs; ++i) {
        const Flight::Leg& leg = flight.legs[i];
        share_[i] = double(leg.share) * std::exp(-before / mean_free_path);
        total_ += share_[i] * -std::expm1(-double(leg.length) / mean_free_path);
        until_[i] = total_;
        before += double(leg.length);
        if (leg.share == 0) break;
    }
}

Vec3 Collisions::at(double u) const {
    Vec3 start(0);
    double scattered = 0;
    for (std::size_t i = 0;; ++i) {
        const Flight::Leg& leg = flight_.legs[i];
        const bool last = i + 1 == Flight::kLegs || share_[i + 1] == 0;
        if (last || u * total_ < until_[i]) {
            const double on_leg = share_[i] > 0 ? (u * total_ - scattered) / share_[i] : 0;
            const double way = -mean_free_path_ * std::log1p(-std::min(on_leg, 1 - 1e-9));
            return start + std::min(float(way), leg.length) * leg.w;
        }
        start += leg.length * leg.w;
        scattered = until_[i];
    }
}

}  // namespace tallow
