// SPDX-License-Identifier: Apache-2.0
// Normalized diffusion: a sum of two exponentials over r, fitted to random walks.
//
//     R = A s (e^(-s r) + e^(-s r / 3)) / (8 pi r),   s = 1.85 - A + 7 |A - 0.8|^3
//
// in reduced mean free paths; A is the total reflectance of the half-space, all orders, which we
// take from the transport table. Source: [CB15], the fit for light that enters at right
// angles, as it does for every other profile here. Their other one, s = 1.9 - A + 3.5 (A - 0.8)^2,
// is for light that enters from all sides.
//
// Against our transport (all orders, matched indices; mean |error| over mean) it is 3 to 6 % off
// for A from 0.03 to 0.75 and 17 % at 0.91; the other s is farther off everywhere. Neither knows
// the boundary: at eta 1.3 it is 10 to 47 %. Softened inside 1e-3 mean free paths, see
// profile_models.h.
#include <algorithm>
#include <numbers>

#include "common/optics/profile_models.h"
#include "common/optics/transport_data.h"

namespace tallow {
namespace {

class NormalizedDiffusion final : public ReducedProfile {
public:
    NormalizedDiffusion(double sigma_t_prime, double albedo)
        : ReducedProfile(sigma_t_prime),
          albedo_(albedo),
          s_(1.85 - albedo + 7 * std::pow(std::abs(albedo - 0.8), 3)) {}

    double reduced(double r2) const override {
        const double r = softened(r2);
        return albedo_ * s_ * (std::exp(-s_ * r) + std::exp(-s_ * r / 3)) /
               (8 * std::numbers::pi * r);
    }

    // A / 4 (e^(-s r) + 3 e^(-s r / 3)) at r = kInnermost
    double total_reflectance() const override {
        const double x = s_ * kInnermost;
        return albedo_ / 4 * (std::exp(-x) + 3 * std::exp(-x / 3));
    }

private:
    double albedo_, s_;
};

}  // namespace

std::unique_ptr<Profile> normalized_diffusion_profile(const ReducedChannel& channel) {
    const double albedo = transport_reflectance(channel, Orders::all).value;
    return std::make_unique<NormalizedDiffusion>(channel.sigma_t_prime, std::min(albedo, 1.0));
}

}  // namespace tallow
