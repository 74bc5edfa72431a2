// SPDX-License-Identifier: Apache-2.0
// The profile of the body-aware model, which is corrected to the body afterwards.
//
//     R_{>= 2} = w P + (1 - w) T_{>= 2},   R_1 = T_{all} - T_{>= 2}
//
// P is photon beam diffusion, T the half-space's own transport. Where absorption is weak, diffusion
// is what the correction speaks about, and errors of P and of diffusion in the body cancel; where
// it is strong, light leaves before it diffuses, and T is right. w rises between two albedos.
#include <algorithm>

#include "common/optics/profile_models.h"

namespace tallow {
namespace {

// Albedos over which photon beam diffusion takes over. docs/BODY_AWARE.md has the measurement.
constexpr double kTransportBelow = 0.97, kDiffusionAbove = 0.99;

class BodyAwareProfile final : public Profile {
public:
    BodyAwareProfile(const ReducedChannel& channel, Orders orders, double weight)
        : diffusion_(photon_beam_diffusion_profile(channel)),
          orders_(transport_profile(channel, orders)),
          multiple_(transport_profile(channel, Orders::two_and_more)),
          weight_(weight) {}

    double operator()(double r2) const override {
        return (*orders_)(r2) + weight_ * ((*diffusion_)(r2) - (*multiple_)(r2));
    }
    double total_reflectance() const override {
        return orders_->total_reflectance() +
               weight_ * (diffusion_->total_reflectance() - multiple_->total_reflectance());
    }

private:
    std::unique_ptr<Profile> diffusion_, orders_, multiple_;
    double weight_;
};

}  // namespace

double share_of_diffusion(double alpha_prime) {
    const double t =
        std::clamp((alpha_prime - kTransportBelow) / (kDiffusionAbove - kTransportBelow), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

std::unique_ptr<Profile> body_aware_profile(const ReducedChannel& channel, Orders orders) {
    const double weight = share_of_diffusion(channel.alpha_prime);
    if (weight == 0) return transport_profile(channel, orders);
    if (weight == 1 && orders == Orders::two_and_more)
        return photon_beam_diffusion_profile(channel);
    return std::make_unique<BodyAwareProfile>(channel, orders, weight);
}

}  // namespace tallow
