// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/scene/scene.h"

namespace tallow {

/// Factors of a translucent material that do not change from point to point.
struct SurfaceFactors {
    float eta;
    Rgb norm{1};   ///< 2 * integral of F_t (1 + slope mu') mu where energy is kept, else 1
    Rgb slope{0};  ///< of Exit::directional
};
SurfaceFactors surface_factors(const SubsurfaceMaterial& material);

/// T(w_o) of L = M / pi * T(w_o), by the exit of the material:
///
///     classic        F_t(eta, mu)
///     normalized     F_t / (2 * integral of F_t mu)
///     directional    F_t (1 + a mu') / (2 * integral of F_t (1 + a mu') mu)
///
/// mu' is the cosine inside, a = 3 / (2 A) the slope of the radiance that diffusion brings to the
/// surface. Where absorption is strong, light leaves before it diffuses: a fades with the share of
/// diffusion in the body-aware profile.
/// Source   [JMLH01] eq. 5 and 8, with the constant that keeps energy; docs/BODY_AWARE.md.
Rgb exit_factor(const SurfaceFactors& factors, float cos_o);

}  // namespace tallow
