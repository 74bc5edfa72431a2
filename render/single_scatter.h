// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "common/geometry/ray_scene.h"
#include "common/optics/medium.h"
#include "common/scene/scene.h"

namespace tallow {

/// Radiance that leaves a body at `hit` towards w_o after exactly one scattering inside.
///
///     L = F_t(w_o) / eta^2 * integral ds sigma_s e^(-sigma_t s)
///           * integral dw_i p(cos) L_i F_t(w_i) cos_i / cos_i' e^(-sigma_t s_i')
///
/// The eye ray is refracted into the body and marched to where it leaves it first. From each of
/// `steps` depths every light is sampled along a straight line; where that line leaves the body
/// lies x_i, with cos_i outside and cos_i' after refraction there. The length inside is corrected
/// for the refraction that the straight line ignores: s_i' = s_i cos_i / cos_i'.
///
/// Depths are drawn by stratified, jittered inversion of the mean over channels of
/// sigma_t e^(-sigma_t s), so that channels of very different density are all served.
///
/// Units    radiance as the lights'.
/// Domain   hit on the outside of object's body: dot(hit.n, w_o) > 0. A light inside the body
///          adds nothing.
/// Error    for parallel light on a half-space below 0.2 % at 64 steps, see the unit test.
/// Source   [JMLH01] section 2.2 and 3.2; cos_i / cos_i' is the change of solid angle and of
///          projected area at the surface, which the paper leaves out.
Rgb single_scatter(const Scene& scene, const RayScene& rays, const Surface& surface,
                   const Medium& medium, const Hit& hit, Vec3 w_o, int steps, std::uint64_t seed);

}  // namespace tallow
