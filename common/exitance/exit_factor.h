// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/scene/scene.h"

namespace tallow {

/// Factors of a translucent material that do not change from point to point.
struct SurfaceFactors {
    float eta;
    float exit_norm;  // 1, or 2 * integral of F_t mu for Exit::normalized
};
SurfaceFactors surface_factors(const SubsurfaceMaterial& material);

/// T(w_o) of L = M / pi * T(w_o): F_t(eta, cos_o), divided by its hemispherical mean for
/// Exit::normalized. Source: [JMLH01] eq. 5 and 8, with the constant that keeps energy.
float exit_factor(const SurfaceFactors& factors, float cos_o);

}  // namespace tallow
