// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/exit_factor.h"

#include "common/optics/fresnel.h"

namespace tallow {

SurfaceFactors surface_factors(const SubsurfaceMaterial& material) {
    const float eta = material.medium.eta;
    const bool normalized = material.exit == Exit::normalized;
    return {eta, normalized ? float(diffuse_fresnel_transmittance(eta)) : 1.0f};
}

float exit_factor(const SurfaceFactors& factors, float cos_o) {
    return fresnel_transmittance(factors.eta, cos_o) / factors.exit_norm;
}

}  // namespace tallow
