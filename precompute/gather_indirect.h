// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "common/base/progress.h"
#include "common/exitance/body_exitance.h"
#include "common/geometry/ray_scene.h"
#include "common/scene/scene.h"
#include "precompute/checkpoint.h"
#include "precompute/gather_patches.h"
#include "precompute/sampled_body.h"

namespace tallow {

struct IndirectOptions {
    int bounces;                                ///< >= 1
    int rays;                                   ///< from each sample, or patch of them
    float tolerance;                            ///< of the exitance that bodies shine with
    std::vector<std::optional<Rgb>> diffuse{};  ///< [object] bodies taken for diffuse surfaces
    std::optional<PatchSize> patches{};         ///< without, every sample has rays of its own
};

/// How much coarser than the tolerance asks for the exitance may be of which bodies send light to
/// each other and themselves: clusters of diffusion, and sums. It is a quarter of the light in what
/// was measured, and the noise of the paths is the same with and without (docs/INDIRECT.md).
inline constexpr double kPathsTolerance = 2;

/// Fills `indirect` of every body: light that reaches a sample after it was reflected, by opaque
/// surfaces or by bodies, this one included.
///
///     E_t(x) = pi * mean over cosine-distributed rays of  F_t(eta, cos) * L(ray)
///
/// L is what LightPaths collect. Bodies shine with the exitance of the light that they have so far;
/// that is repeated `bounces` times, so that light which goes in and out of bodies several times is
/// counted as often. In a path that meets a body after d diffuse reflections both add up: paths of
/// up to 2 * bounces - 1 reflections are in part included.
///
/// Samples are gathered for together, in patches where light is smooth (GatherPatches). The rays of
/// a patch are consecutive points of one low-discrepancy sequence for the whole body, in the order
/// of the patches, so that neighbours in space are stratified together: exitance averages over
/// them.
///
/// Units    W/mm^2 per channel and light group; the groups' scales are not applied.
/// Source   [JB02] section 3 leaves the irradiance to any global illumination method.
/// What `checkpoint` has is not gathered again.
///
/// Returns [body] the worst of what became of its solves for diffusion.
std::vector<DiffusionReport> gather_indirect(const Scene& scene, const RayScene& rays,
                                             std::vector<SampledBody>& bodies,
                                             const IndirectOptions& options, Checkpoint& checkpoint,
                                             Progress& progress);

}  // namespace tallow
