// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "common/nbody/kernel_table.h"
#include "common/optics/profile.h"

namespace tallow {

/// What the sums over the samples of a body are taken with, so that they are right for any ratio of
/// the samples' spacing h to the mean free path. docs/FINE_MEDIA.md derives and measures it.
///
/// A profile that changes over less than h would make single samples visible: it is averaged with a
/// Gaussian g of about the width of h. What that blurs is put back from the
/// irradiance at the shading point itself (ControlVariate).
struct ExitanceKernels {
    std::array<KernelTable, 3> profiles;  // R or R * g, in a common unit
    // Weights of the control variate, all 0 where the samples resolve R. See NearbyParts.
    std::array<double, 3> beta{}, kappa{};
    double sigma = 0;       // of g, mm; the control variate's, and R's where beta > 0
    bool smoothed = false;  // any of the profiles

    bool needs_irradiance() const { return beta != std::array<double, 3>{}; }
};

/// What single scattering by the medium itself adds at right angles, of the first order of the
/// reduced medium: at most 1, and 1 for g <= 0.
double first_order_marched(const Medium& medium, int channel);

/// The profile that multiple scattering is summed with. `transport` and `body_aware` tell orders
/// apart in the reduced medium, where one isotropic scattering stands for many forward ones: with g
/// > 0 its first order is more than single scattering adds, and the rest of it has to stay in the
/// profile.
///
///     R = R_{>= 2} + (1 - s) R_1,   s = first_order_marched()
///
/// Other models, and Orders::all, are as make_profile() has them.
std::unique_ptr<Profile> make_exitance_profile(Model model, const Medium& medium, int channel,
                                               Orders orders);

/// Kernels for samples `spacing_mm` apart.
ExitanceKernels make_exitance_kernels(Model model, const Medium& medium, Orders orders,
                                      double spacing_mm);

/// The profiles themselves, for samples that are close enough. Some 30 ms for
/// photon_beam_diffusion, less for the others.
std::array<KernelTable, 3> tabulate_profiles(Model model, const Medium& medium, Orders orders);

}  // namespace tallow
