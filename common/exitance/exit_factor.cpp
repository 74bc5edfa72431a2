// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/exit_factor.h"

#include "common/optics/fresnel.h"

namespace tallow {

SurfaceFactors surface_factors(const SubsurfaceMaterial& material) {
    const float eta = material.medium.eta;
    if (material.exit == Exit::classic) return {eta};
    return {eta, float(diffuse_fresnel_transmittance(double(eta)))};
}

float exit_factor(const SurfaceFactors& factors, float cos_o) {
    return fresnel_transmittance(factors.eta, cos_o) / factors.norm;
}

}  // namespace tallow
