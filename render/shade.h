// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/lighting/direct_light.h"
#include "common/lighting/light_paths.h"
#include "render/primary_hits.h"

namespace tallow {

/// Light that diffuse surfaces and plastics reflect towards where they are seen from; mirrors and
/// bodies reflect none of it.
///
///     diffuse   L = rho / pi * E
///     plastic   L = rho / (1 - rho F_dr) * E_t / (pi eta^2) * F_t(eta, cos_o)
///     body      L = R_total / pi * E_t * T(w_o), where it is taken for a diffuse surface
class ReflectedLight {
public:
    /// Light may be reflected `bounces` times before it reaches the surface that is seen.
    /// Objects with a reflectance in `diffuse` [object] are bodies taken for diffuse surfaces.
    ReflectedLight(const Scene& scene, const RayScene& rays, int bounces,
                   const std::vector<std::optional<Rgb>>& diffuse = {});

    /// Of light that comes straight from the lights; each area light gets `light_samples` rays.
    Rgb direct(const ShadingPoint& point, int light_samples) const;

    /// Of light that was reflected before, found along `paths` paths. What they met of bodies is
    /// appended to `vertices` under the number `receiver`, with factors that make of an exitance
    /// the radiance seen.
    Rgb indirect(const ShadingPoint& point, int paths, std::uint32_t receiver,
                 std::vector<BodyVertex>& vertices) const;

    /// Direct light that crosses the smooth surface of a body, its tinted irradiance E_t.
    Rgb entering(const ShadingPoint& point, const SubsurfaceMaterial& material,
                 int light_samples) const;

private:
    /// L = factor / pi * integral of accept(cos) L_i cos dw.
    struct Base {
        Rgb factor;
        Acceptance accept;
    };
    Base base_at(const ShadingPoint& point) const;
    Rgb direct_irradiance(const ShadingPoint& point, int light_samples, Acceptance accept) const;

    const Scene& scene_;
    const RayScene& rays_;
    int bounces_;
    LightPaths paths_;
    std::vector<std::optional<Rgb>> diffuse_;             // [object]
    std::vector<std::optional<SurfaceFactors>> factors_;  // [material] of translucent ones
    std::vector<float> F_dr_;                             // [material] of plastics, else 0
};

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
