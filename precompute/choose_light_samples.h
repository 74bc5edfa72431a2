// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "precompute/gather_irradiance.h"

namespace tallow {

/// `rays` for each light that has a size, one for the others.
LightSampleCounts equal_light_samples(const Scene& scene, int rays);

}  // namespace tallow
