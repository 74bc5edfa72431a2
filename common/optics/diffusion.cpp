// SPDX-License-Identifier: Apache-2.0
#include "common/optics/diffusion.h"

#include <algorithm>

#include "common/optics/fresnel.h"
#include "common/optics/quadrature.h"

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

double half_space_fluence(double r2, double z, const DiffusionConstants& k) {
    // The integrand grows as l up to the smaller of d and z_b = 1 / h, and is cut off by e^(-h l).
    constexpr double kNearest = 1e-3, kFarthest = 30, kStep = 0.8;
    const double nearest = kNearest * std::min(std::sqrt(r2 + z * z), k.z_b);
    const double sum = integrate_log(nearest, kFarthest * k.z_b, kStep, [&](double l) {
        return std::exp(-l / k.z_b) * image_pair(r2, z, z + l, k.s).fluence;
    });
    return 2 / k.z_b * sum;
}

}  // namespace tallow
