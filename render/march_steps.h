// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/optics/profile.h"

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
/// below a third of the tolerance of the whole radiance: the smallest power of two with
///
///     share * error(steps) <= tolerance / 3,
///
/// with the largest errors of the table at single_scatter(), and no more than 1024. A tolerance
/// below 1e-4 counts as that.
int march_steps_of_pixel(Model model, const Medium& medium, double tolerance);

}  // namespace tallow
