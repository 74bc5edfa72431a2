// SPDX-License-Identifier: Apache-2.0
#include "common/optics/diffusion.h"

#include "common/optics/fresnel.h"

namespace tallow {

ReducedChannel reduced_channel(const Medium& medium, int channel) {
    const double sigma_a = medium.sigma_a[channel], sigma_s_prime = medium.sigma_s_prime[channel];
    const double sigma_t_prime = sigma_s_prime + sigma_a;
    return {sigma_s_prime / sigma_t_prime, sigma_a / sigma_t_prime, sigma_t_prime, medium.eta};
}

DiffusionConstants diffusion_constants(double absorption, double eta) {
    const double C1 = fresnel_moment(1 / eta, 1), C2 = fresnel_moment(1 / eta, 2);
    const double A = (1 + 3 * C2) / (1 - 2 * C1), D = (1 + absorption) / 3;
    return {A, (1 - 2 * C1) / 4, (1 - 3 * C2) / 2, D, std::sqrt(absorption / D), 2 * A * D};
}

}  // namespace tallow
