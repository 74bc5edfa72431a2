// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/optics/diffusion.h"
#include "common/optics/profile.h"

namespace tallow {

/// How much light leaves after two scatterings or more, from two estimates: by what scatters for
/// the last time on the way out, and by what diffusion lets leave in all, B, less what leaves after
/// one.
///
///     M = weight alpha' (B - c phi_1) + (1 - weight) (by the last flight)
///     weight = max(0, 1 - 1.5 sqrt(1 - alpha'))
///
/// phi_1 is the fluence of light that scattered once, kAbove mean free paths above the surface; c
/// makes of it what leaves, here of a half-space whose sources decay with the depth. With
/// Orders::all that is added again. The second estimate knows that no light is lost, the first how
/// absorption acts; the weight is chosen by transport in slabs.
///
/// Error    of the two sides of slabs, docs/BODY_AWARE.md.
class LightBalance {
public:
    /// Chosen: higher, oblique light counts less, as Fresnel has it, and single samples do not
    /// show; but what stands opposite to a hollow comes near.
    static constexpr double kAbove = 0.5;

    LightBalance(const ReducedChannel& reduced, Orders orders);

    /// All W/mm^2. Linear in the light.
    double leaving(double B, double phi_1, double by_last_flight) const {
        return weight_ * alpha_prime_ * (B - c_ * phi_1) + (1 - weight_) * by_last_flight +
               of_first_ * c_ * phi_1;
    }

private:
    double weight_, alpha_prime_, c_, of_first_;
};

}  // namespace tallow
