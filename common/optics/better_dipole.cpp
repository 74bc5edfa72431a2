// SPDX-License-Identifier: Apache-2.0
// The better dipole: a point source at one mean free path, Grosjean's diffusion coefficient, and an
// exitance of fluence and flux with the exact moments of the boundary.
//
//     R = alpha'^2 / (4 pi) (C_E flux + C_phi / D fluence),   z = 1,   z_v = 1 + 2 z_b
//
// with flux and fluence of image_pair(). Source: [d'Eon12]. alpha' is squared because Grosjean's
// form describes light after its first collision.
#include <numbers>

#include "common/optics/profile_models.h"

namespace tallow {
namespace {

class BetterDipole final : public ReducedProfile {
public:
    explicit BetterDipole(const ReducedChannel& channel)
        : ReducedProfile(channel.sigma_t_prime),
          alpha2_(channel.alpha_prime * channel.alpha_prime),
          k_(diffusion_constants(channel.absorption, channel.eta)) {}

    double reduced(double r2) const override {
        return alpha2_ / (4 * std::numbers::pi) * exitance(image_pair(r2, 1, k_), k_);
    }

    // alpha'^2 / 2 (C_E (e^-s + e^(-s z_v)) + C_phi / D (e^-s - e^(-s z_v)) / s)
    double total_reflectance() const override {
        const double gap = 2 * k_.z_b, x = k_.s * gap;
        const double fluence = x > 0 ? -std::expm1(-x) / k_.s : gap;
        return alpha2_ / 2 * std::exp(-k_.s) *
               (k_.C_E * (1 + std::exp(-x)) + k_.C_phi / k_.D * fluence);
    }

private:
    double alpha2_;
    DiffusionConstants k_;
};

}  // namespace

std::unique_ptr<Profile> better_dipole_profile(const ReducedChannel& channel) {
    return std::make_unique<BetterDipole>(channel);
}

}  // namespace tallow
