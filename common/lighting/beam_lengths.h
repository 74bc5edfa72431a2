// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/exitance/lit_samples.h"
#include "common/geometry/ray_scene.h"

namespace tallow {

/// How far light that entered at each sample goes straight on before it leaves the body, mm, at
/// most `longest`. Empty if that is 0.
std::vector<float> beam_lengths(const RayScene& rays, std::uint32_t object, const LitSamples& lit,
                                float longest);

}  // namespace tallow
