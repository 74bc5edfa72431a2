// SPDX-License-Identifier: Apache-2.0
// Photon beam diffusion of a beam that enters at right angles, scattering orders >= 2.
//
//     R = alpha'^2 / (4 pi) * integral over t of
//             e^-t (1 - e^(-2 (d + t))) (C_E flux + C_phi / D fluence),   z = t, z_v = t + 2 z_b
//
// in reduced mean free paths, with flux and fluence of image_pair(). Source: [HCJ13], with the
// exact moments of [d'Eon12] in place of polynomial fits. The factor 1 - e^(..) is their empirical
// correction close to the beam; it leaves R growing as -ln r there, so that the profile is softened
// inside 1e-3 mean free paths, see profile_models.h.
#include <algorithm>
#include <numbers>

#include "common/optics/profile_models.h"
#include "common/optics/quadrature.h"

namespace tallow {
namespace {

// The integrand lives between the smaller of r and 1, and 1; below it falls as t or faster.
// Against brute force in t the profile is within 1e-5 (profile_test.cpp).
constexpr double kNearest = 1e-6, kDeepest = 40, kStep = 0.4;

class PhotonBeamDiffusion final : public ReducedProfile {
public:
    explicit PhotonBeamDiffusion(const ReducedChannel& channel)
        : ReducedProfile(channel.sigma_t_prime),
          alpha2_(channel.alpha_prime * channel.alpha_prime),
          k_(diffusion_constants(channel.absorption, channel.eta)) {
        // Without absorption R falls as r^-3: 1e-8 of the light leaves beyond the end.
        total_ = 2 * std::numbers::pi * integrate_log(kInnermost, 1e8, 0.2, [this](double r) {
                     return r * unsoftened(r);
                 });
    }

    double reduced(double r2) const override { return unsoftened(softened(r2)); }
    double total_reflectance() const override { return total_; }

private:
    double unsoftened(double r) const {
        const double sum =
            integrate_log(kNearest * std::min(r, 1.0), kDeepest, kStep, [&](double t) {
                const ImagePair pair = image_pair(r * r, t, k_);
                return std::exp(-t) * -std::expm1(-2 * (pair.d + t)) * exitance(pair, k_);
            });
        return alpha2_ / (4 * std::numbers::pi) * sum;
    }

    double alpha2_;
    DiffusionConstants k_;
    double total_;
};

}  // namespace

std::unique_ptr<Profile> photon_beam_diffusion_profile(const ReducedChannel& channel) {
    return std::make_unique<PhotonBeamDiffusion>(channel);
}

}  // namespace tallow
