// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "common/geometry/ray_scene.h"
#include "common/optics/medium.h"
#include "common/scene/scene.h"
#include "render/refracted_connection.h"

namespace tallow {

class InnerLight;

/// How refracted paths into a mesh are found where a body has `exact`; delta lights are searched
/// for always.
enum class LampPaths {
    searched,   ///< to points that are drawn on lights, by RefractedConnections
    sky_drawn,  ///< likewise, but an even sky is met by rays from the places: see EntryDirections
    drawn       ///< all by such rays
};

/// A body in which light is scattered. `surface` is that of `object`; `exact` and `inner`, if any,
/// belong to the same surface.
struct ScatteringBody {
    const Scene& scene;
    const RayScene& rays;
    const Surface& surface;
    std::uint32_t object;
    const Medium& medium;
    const RefractedConnections* exact = nullptr;
    SurfaceColor albedo{Rgb(1)};
    const InnerLight* inner = nullptr;
    LampPaths lamps = LampPaths::searched;
};

/// Where a body is seen, from outside: dot(hit.n, w_o) > 0. Points with the same seed have steps
/// from different parts of the same sequence and are stratified together.
struct EyePoint {
    const Hit& hit;
    Vec3 w_o;  // unit, towards the eye
    std::uint64_t seed;
    std::uint32_t first_step = 0;
};

/// Depths at which light is collected, for a point and for all points with the same seed. Powers of
/// two are best.
struct MarchSteps {
    int of_point, together;
};
inline MarchSteps lone_steps(int steps) { return {steps, steps}; }

/// Radiance that leaves a body at each point towards w_o after exactly one scattering inside.
///
///     L = F_t(w_o) / eta^2 * integral ds sigma_s e^(-sigma_t s)
///           * integral dw_i p(cos) L_i F_t(w_i) cos_i / cos_i' e^(-sigma_t s_i')
///
/// The eye ray is refracted into the body and marched to where it leaves it first; with `exact` it
/// goes on where it is reflected inside, see follow_eye_rays(). Depths, see
/// DepthSampler, and light samples are the three dimensions of one low-discrepancy sequence, with
/// every second depth mirrored into the stratum of the one before. Bundles of rays go to the ray
/// tracer together, so that many points at a time take less time each.
///
/// Without `exact`, every light is sampled from each depth along a straight line; where that line
/// leaves the body lies x_i, with cos_i outside and cos_i' after refraction there. The length
/// inside is corrected for the refraction that the straight line ignores: s_i' = s_i cos_i /
/// cos_i'.
///
/// With `exact`, which belongs to the same surface, light is sampled without regard to the depth
/// and followed along every path that Snell's law allows: a light of area A and radiance L, drawn
/// at y, gives L A cos_y F_t(cos_i) |dOmega_y / dA_x| in place of L F_t cos_i / cos_i' dw_i. See
/// RefractedConnections. Paths through meshes are searched up to a length that is drawn by chance.
/// Where `lamps` says so, light is found by rays from the depths that are bent outwards instead,
///
///     eta^2 F_t(cos_i) L e^(-sigma_t s_i) / density(w)
///
/// the same in the mean with more noise; see EntryDirections.
///
/// With `inner` light is added that was reflected inside before it scatters. Where it focuses,
/// noise is unbounded in principle (the density is the inverse root of the distance to a caustic);
/// in pictures it is hardly seen.
///
/// The body's albedo tints light where it enters and where it leaves; see surface_tint().
///
/// Straight lines are given up after 40 mean free paths of the clearest channel, except in a
/// half-space.
///
/// A light inside the body adds nothing in either version: light enters through the surface only.
/// Other bodies are opaque to light on its way to the surface and absent inside: a body within a
/// body gets no light, and the outer one does not notice it.
///
/// Units    radiance as the lights'.
/// Error    of the march, relRMSE over rays and channels, against 2048 steps:
///
///              steps   marble: plane  ball   lamp   skin1: plane  ball   lamp
///                1             0.60   0.57   0.59           0.57  0.46   0.55
///                2             0.045  0.044  0.20           0.089 0.067  0.19
///                4             0.012  0.013  0.090          0.025 0.020  0.086
///                8             0.003  0.004  0.040          0.007 0.025  0.039
///               16             0.001  0.001  0.034          0.002 0.014  0.031
///               32             3e-4   4e-4   0.011          7e-4  0.010  0.010
///               64             7e-5   1e-4   0.004          2e-4  0.004  0.004
///
///          Half-space and ball of radius 5 mm under parallel light, the ball under a square lamp;
///          by `render_test --gtest_filter=SingleScatter.ErrorOfTheMarch*`.
///          Of the straight line, on a wax ball of radius 12 mm under parallel light from the side,
///          by the cosine of the surface to the light: 2 % too dark from 0.4 to 1, right at 0.35,
///          6 % too bright at 0.25, 28 % at 0.15, 160 % at 0.05, and bright beyond the terminator,
///          where nearly no light is. Exact paths take 2 to 3 times as long on a sphere, and about
///          5 times on the bunny (flat, 75k triangles).
/// Source   [JMLH01] section 2.2 and 3.2; cos_i / cos_i' is the change of solid angle and of
///          projected area at the surface, which the paper leaves out. [WZHB09] for exact paths.
void single_scatter(const ScatteringBody& body, std::span<const EyePoint> points, MarchSteps steps,
                    std::span<Rgb> result);

/// The same for one point.
Rgb single_scatter(const ScatteringBody& body, const EyePoint& point, MarchSteps steps);

}  // namespace tallow
