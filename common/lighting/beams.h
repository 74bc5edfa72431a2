// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/diffusion/body_diffusion.h"
#include "common/exitance/lit_samples.h"
#include "common/geometry/ray_scene.h"

namespace tallow {

/// The ways of light inside a body of index `eta`, from each sample where it entered, for `longest`
/// mm: at the surface a share of it is mirrored by Fresnel's equations, the rest leaves. Empty if
/// `longest` is 0.
std::vector<Beam> follow_beams(const RayScene& rays, std::uint32_t object, const LitSamples& lit,
                               float eta, float longest);

}  // namespace tallow
