// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "common/geometry/ray_scene.h"
#include "common/optics/medium.h"
#include "common/scene/scene.h"
#include "render/refracted_connection.h"

namespace tallow {

/// Radiance that leaves a body at `hit` towards w_o after exactly one scattering inside.
///
///     L = F_t(w_o) / eta^2 * integral ds sigma_s e^(-sigma_t s)
///           * integral dw_i p(cos) L_i F_t(w_i) cos_i / cos_i' e^(-sigma_t s_i')
///
/// The eye ray is refracted into the body and marched to where it leaves it first, at `steps`
/// depths, drawn by stratified, jittered inversion of the mean over channels of
/// sigma_t e^(-sigma_t s), so that channels of very different density are all served.
///
/// Without `exact`, every light is sampled from each depth along a straight line; where that line
/// leaves the body lies x_i, with cos_i outside and cos_i' after refraction there. The length
/// inside is corrected for the refraction that the straight line ignores: s_i' = s_i cos_i /
/// cos_i'.
///
/// With `exact`, which belongs to the same surface, light is sampled without regard to the depth
/// and followed along every path that Snell's law allows: a light of area A and radiance L, drawn
/// at y, gives L A cos_y F_t(cos_i) |dOmega_y / dA_x| in place of L F_t cos_i / cos_i' dw_i. See
/// RefractedConnections. Where it focuses, noise is unbounded in principle (the density is the
/// inverse root of the distance to a caustic); in pictures it is hardly seen.
///
/// `albedo` tints light where it enters and where it leaves; see surface_tint().
///
/// A light inside the body adds nothing in either version: light enters through the surface only.
/// Other bodies are opaque to light on its way to the surface and absent inside: a body within a
/// body gets no light, and the outer one does not notice it.
///
/// Units    radiance as the lights'.
/// Domain   hit on the outside of object's body: dot(hit.n, w_o) > 0.
/// Error    of the march, relRMSE over rays and channels, against 2048 steps:
///
///              steps   marble: plane  ball   lamp   skin1: plane  ball   lamp
///                1             0.58   0.55   0.58           0.55  0.44   0.53
///                4             0.030  0.027  0.100          0.040 0.030  0.096
///               16             0.008  0.008  0.015          0.008 0.008  0.015
///               64             0.001  0.001  0.004          0.001 0.003  0.004
///
///          Half-space and ball of radius 5 mm under parallel light, the ball under a square lamp;
///          by `render_test --gtest_filter=SingleScatter.ErrorOfTheMarch*`.
///          Of the straight line, on a wax ball of radius 12 mm under parallel light from the side,
///          by the cosine of the surface to the light: 2 % too dark from 0.4 to 1, right at 0.35,
///          6 % too bright at 0.25, 28 % at 0.15, 160 % at 0.05, and bright beyond the terminator,
///          where nearly no light is. Exact paths take 2 to 3 times as long on a sphere; on a
///          mesh of 126k triangles 70 (flat) to 300 times (smooth), 0.1 to 0.4 ms a light and
///          depth.
/// Source   [JMLH01] section 2.2 and 3.2; cos_i / cos_i' is the change of solid angle and of
///          projected area at the surface, which the paper leaves out. [WZHB09] for exact paths.
Rgb single_scatter(const Scene& scene, const RayScene& rays, const Surface& surface,
                   const Medium& medium, const Hit& hit, Vec3 w_o, int steps, std::uint64_t seed,
                   const RefractedConnections* exact = nullptr,
                   const SurfaceColor& albedo = Rgb(1));

}  // namespace tallow
