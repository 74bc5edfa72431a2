// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/geometry/ray_scene.h"
#include "common/scene/scene.h"
#include "render/primary_hits.h"

namespace tallow {

/// Direct light on a diffuse or plastic surface, reflected towards point.w_o; zero for mirrors.
///
///     diffuse   L = rho / pi * E
///     plastic   L = rho / (1 - rho F_dr) * E_t / (pi eta^2) * F_t(eta, cos_o)
///
/// Each area light gets `light_samples` shadow rays.
Rgb reflect_direct_light(const Scene& scene, const RayScene& rays, const ShadingPoint& point,
                         int light_samples);

/// Direct light that crosses the smooth surface of a body at a point, its irradiance E_t.
Rgb transmitted_direct_light(const Scene& scene, const RayScene& rays, const ShadingPoint& point,
                             int light_samples, float eta);

/// Colour of a material for the albedo layer: the share of light that it gives back.
Rgb albedo(const Material& material);

}  // namespace tallow
