// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/exit_factor.h"

#include <cmath>

#include "common/optics/diffusion.h"
#include "common/optics/fresnel.h"
#include "common/optics/profile.h"

namespace tallow {
namespace {

float cosine_inside(float eta, float cos_o) {
    return std::sqrt(1 - (1 - cos_o * cos_o) / (eta * eta));
}

// 2 * integral of F_t mu' mu dmu by the midpoint rule, to 1e-6.
double transmitted_cosine(float eta) {
    constexpr int kSteps = 2000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const float mu = (float(i) + 0.5f) / kSteps;
        sum += 2 * double(fresnel_transmittance(eta, mu) * cosine_inside(eta, mu) * mu) / kSteps;
    }
    return sum;
}

Rgb slope_at_surface(const Medium& medium) {
    const auto a = float(1.5 / diffusion_constants(0, double(medium.eta)).A);
    return map(medium.alpha_prime(),
               [a](float alpha) { return a * float(share_of_diffusion(double(alpha))); });
}

}  // namespace

SurfaceFactors surface_factors(const SubsurfaceMaterial& material) {
    const float eta = material.medium.eta;
    if (material.exit == Exit::classic) return {eta};
    const Rgb even(float(diffuse_fresnel_transmittance(eta)));
    if (material.exit == Exit::normalized) return {eta, even};
    const Rgb slope = slope_at_surface(material.medium);
    return {eta, even + float(transmitted_cosine(eta)) * slope, slope};
}

Rgb exit_factor(const SurfaceFactors& factors, float cos_o) {
    return fresnel_transmittance(factors.eta, cos_o) *
           (Rgb(1) + cosine_inside(factors.eta, cos_o) * factors.slope) / factors.norm;
}

}  // namespace tallow
