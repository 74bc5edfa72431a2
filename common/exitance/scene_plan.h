// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "common/base/plan.h"
#include "common/scene/scene.h"
#include "common/scene/scene_geometry.h"

namespace tallow {

/// How a translucent object is computed.
enum class Treatment {
    samples,  ///< sampled, its exitance summed over the samples
    diffuse,  ///< as a diffuse surface of the medium's total reflectance: no samples
    unseen    ///< not at all: no camera sees it and it lights nothing
};

/// What of a scene is computed, decided from the scene alone, so that both programs agree.
struct ScenePlan {
    /// The scene with every `auto` of single scattering and transmission decided.
    Scene scene;
    std::vector<Treatment> treatment;         // [object]; samples for opaque ones
    std::vector<std::optional<Rgb>> diffuse;  // [object] total reflectance of diffuse bodies
    Plan plan;
};

/// Decides for a tolerance (relRMSE of the picture). With settings.everything nothing is left out
/// that is not switched off by hand.
ScenePlan plan_scene(const Scene& scene, const SceneGeometry& geometry, double tolerance);

/// Bound of single scattering's share of the light of a half-space in any direction, for light from
/// any direction; docs/PLAN.md derives it.
///
///     share <= alpha p_max pi / (2 eta^2 cos_c R_total) * c_exit
///
/// p_max is the phase function's largest value over the angles by which light can be turned that
/// enters and leaves through the surface: at least pi - 2 asin(1 / eta).
double single_scattering_bound(const SubsurfaceMaterial& material);

/// Triangles of a mesh within three mean free paths of the clearest channel of a place in it, as if
/// it were flat there and evenly meshed: what a search for refracted paths has to do with. 0 of
/// other surfaces.
double triangles_in_reach(const Surface& surface, const Medium& medium);

/// Beyond, a search does not end in reasonable time: the elephant of 126k triangles in chicken1,
/// 25,000, did not within 40 s of a processor for 16 depths a pixel at 128 x 128. The standard
/// cases are below 1200.
inline constexpr double kMostInReach = 10000;

}  // namespace tallow
