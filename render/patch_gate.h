// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "render/beam_gate.h"
#include "render/refraction_bound.h"

namespace tallow {

/// RefractionCull::may_refract() for many queries at once: bit i is set if the part of the surface
/// may refract light to query i. Conservative in the same sense, with the same tests.
std::uint32_t may_refract(const PatchBound& bound, const BeamQueries& queries);

}  // namespace tallow
