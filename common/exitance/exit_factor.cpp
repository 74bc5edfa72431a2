// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/exit_factor.h"

#include <cmath>

#include "common/optics/diffusion.h"
#include "common/optics/fresnel.h"

namespace tallow {

SurfaceFactors surface_factors(const SubsurfaceMaterial& material) {
    const float eta = material.medium.eta;
    const bool normalized = material.exit == Exit::normalized;
    if (material.exit != Exit::directional)
        return {eta, normalized ? float(diffuse_fresnel_transmittance(eta)) : 1.0f};
    const double A = diffusion_constants(0, double(eta)).A, a = 1.5 / A;
    constexpr int kSteps = 2000;
    double norm = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double mu = (i + 0.5) / kSteps;
        const double inside = std::sqrt(1 - (1 - mu * mu) / (double(eta) * double(eta)));
        norm += 2 * double(fresnel_transmittance(eta, float(mu))) * (1 + a * inside) * mu / kSteps;
    }
    return {eta, float(norm), float(a)};
}

float exit_factor(const SurfaceFactors& factors, float cos_o) {
    const float inside = std::sqrt(1 - (1 - cos_o * cos_o) / (factors.eta * factors.eta));
    return fresnel_transmittance(factors.eta, cos_o) * (1 + factors.slope * inside) /
           factors.exit_norm;
}

}  // namespace tallow
