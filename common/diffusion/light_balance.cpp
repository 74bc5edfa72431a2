// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/light_balance.h"

#include <algorithm>
#include <cmath>

#include "common/optics/fresnel.h"

namespace tallow {
namespace {

// Of a half-space whose light entered under the cosine mu_0 inside, with mu that of what leaves:
//
//     leaving = integral of T mu / (mu + mu_0),   phi_1 = integral of e^(-above / mu) / (mu + mu_0)
double leaving_by_fluence(double eta) {
    constexpr int kSteps = 2000;    // of the midpoint rule
    constexpr double kEntry = 0.9;  // mu_0; refraction leaves no cosine below 0.64
    double leaving = 0, phi_1 = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double mu = (i + 0.5) / kSteps;
        leaving += double(fresnel_transmittance(float(1 / eta), float(mu))) * mu / (mu + kEntry);
        phi_1 += std::exp(-LightBalance::kAbove / mu) / (mu + kEntry);
    }
    return leaving / phi_1;
}

}  // namespace

LightBalance::LightBalance(const ReducedChannel& reduced, Orders orders)
    : weight_(std::max(0.0, 1 - 1.5 * std::sqrt(1 - reduced.alpha_prime))),
      alpha_prime_(reduced.alpha_prime),
      c_(leaving_by_fluence(reduced.eta)),
      of_first_(orders == Orders::all ? 1 : 0) {}

}  // namespace tallow
