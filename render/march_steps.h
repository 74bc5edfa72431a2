// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "common/optics/profile.h"
#include "common/scene/scene.h"
#include "render/single_scatter.h"

namespace tallow {

/// Part of the light that a half-space returns after exactly one scattering, of all that it
/// returns by `model` and single scattering together: root mean square over mean of the channels,
/// as relRMSE counts them.
///
///     share = rms(R_1) / mean(R_1 + R),   R_1 <= alpha / 2 * integral of T mu / (1 + mu) * p(-1) 4
///     pi
///
/// Of isotropic scattering with the unreduced albedo, which returns at least as much as g > 0; for
/// g < 0 the phase function's largest value bounds it. The directions of light and eye change R_1
/// by 1 / (mu_i' + mu_o') only, cosines inside, which at eta 1.5 is a factor of 1.34 at most.
double single_scattering_share(Model model, const Medium& medium);

/// Depths for each pixel, shared by its camera rays, so that the noise of single scattering stays
/// within the tolerance of the whole radiance, as that of shadow rays does: the smallest power of
/// two with
///
///     share * noise(steps) <= tolerance,   noise(steps) = 1.25 steps^-0.9
///
/// and no more than 1024. A tolerance below 1e-4 counts as that.
///
/// Error    noise() is fitted to pictures of the bunny in marble under a lamp of 36 mm, which are
///          worse than the table at single_scatter(): light comes from behind, most of the picture
///          is dark, and the lamp's edge is near the horizon of much of the rest. relRMSE of the
///          layer against 1024 depths, 128 x 128 pixels:
///
///              depths   lamp of 36 mm   lamp of 6 mm   parallel light   sky
///                   2       0.69                                        1.0
///                   8       0.19            0.089           0.046       0.31
///                  64       0.031                                       0.048
///
///          Under the sky noise is 1.5 times that of the fit: half of its directions cross the
///          body.
int march_steps_of_pixel(Model model, const Medium& medium, double tolerance);

/// settings.single_scattering_depths, or the same as above without a number.
int march_steps_of_pixel(const SubsurfaceMaterial& material, const Settings& settings,
                         double tolerance);

/// Depths shared by the camera rays of a pixel, rounded down, but at least one a ray.
inline MarchSteps share_steps(int steps_of_pixel, int samples) {
    return {std::max(1, steps_of_pixel / samples), std::max(steps_of_pixel, samples)};
}

}  // namespace tallow
