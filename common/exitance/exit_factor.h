// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/scene/scene.h"

namespace tallow {

/// Factors of a translucent material that do not change from point to point.
struct SurfaceFactors {
    float eta;
    float exit_norm;  // 1, or 2 * integral of F_t (1 + a mu') mu where energy is kept
    float slope = 0;  // a of Exit::directional
};
SurfaceFactors surface_factors(const SubsurfaceMaterial& material);

/// T(w_o) of L = M / pi * T(w_o): F_t(eta, cos_o), for Exit::normalized divided by its
/// hemispherical mean, for Exit::directional F_t (1 + a mu') divided by the same, with mu' the
/// cosine inside and a = 3 / (2 A): the directions in which diffusion reaches the surface. Source
/// [JMLH01] eq. 5 and 8, with the constant that keeps energy; docs/BODY_AWARE.md.
float exit_factor(const SurfaceFactors& factors, float cos_o);

}  // namespace tallow
