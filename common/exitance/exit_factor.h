// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/scene/scene.h"

namespace tallow {

/// Factors of a translucent material that do not change from point to point.
struct SurfaceFactors {
    float eta;
    float norm = 1;  ///< 2 * integral of F_t mu where energy is kept, else 1
};
SurfaceFactors surface_factors(const SubsurfaceMaterial& material);

/// T(w_o) of L = M / pi * T(w_o): F_t for Exit::classic, F_t / (2 * integral of F_t mu) for the
/// others. That of Exit::directional has the directions of light inside in M; see LeavingField.
/// Source   [JMLH01] eq. 5 and 8, with the constant that keeps energy.
float exit_factor(const SurfaceFactors& factors, float cos_o);

}  // namespace tallow
