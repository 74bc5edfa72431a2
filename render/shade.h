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
/// Each area light gets `light_samples` shadow rays, stratified together with those of the pixel's
/// other camera rays.
Rgb reflect_direct_light(const Scene& scene, const RayScene& rays, const ShadingPoint& point,
                         int light_samples);

/// Shadow rays to each area light on opaque surfaces, for a pixel: the power of two nearest to what
/// makes their noise equal to the tolerance, where all camera rays hit the same surface.
///
/// Error    0.35 / rays, relRMSE over the table of scenes/bunny.yaml against 4096 rays; measured
///          0.089, 0.043, 0.022, 0.012, 0.0068 with 4, 8, 16, 32, 64. Half of the pixels have less
///          than a seventh of it: noise is in the penumbra.
int shadow_rays_of_pixel(double tolerance);

/// Colour of a material for the albedo layer: the share of light that it gives back.
Rgb albedo(const Material& material);

}  // namespace tallow
