// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/optics/diffusion.h"

namespace tallow {

/// How much light leaves after two scatterings or more, from two estimates: by what scatters for
/// the last time on the way out, and by what diffusion lets leave in all, B, less what leaves after
/// one, M_1.
///
///     M = weight alpha' (B - M_1) + (1 - weight) (by the last flight)
///     weight = max(0, 1 - 1.5 sqrt(1 - alpha'))
///
/// The second estimate knows that no light is lost, the first how absorption acts; the weight is
/// chosen by transport in slabs.
///
/// Error    of slabs, bars and balls: docs/BODY_AWARE.md.
class LightBalance {
public:
    explicit LightBalance(const ReducedChannel& reduced);

    /// All W/mm^2. Linear in the light.
    double leaving(double B, double once, double by_last_flight) const {
        return weight_ * alpha_prime_ * (B - once) + (1 - weight_) * by_last_flight;
    }

private:
    double weight_, alpha_prime_;
};

}  // namespace tallow
