// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/progress.h"
#include "common/geometry/ray_scene.h"
#include "common/scene/scene.h"
#include "precompute/sample_surface.h"

namespace tallow {

/// Direct light of one light group on the samples of one body; see GroupIrradianceView.
struct GroupIrradiance {
    std::vector<Rgb> E_t;   // [sample] W/mm^2
    std::vector<Vec3> w_i;  // [sample]
};

/// Gathers direct light on every sample, one result a light group; the groups' scales are not
/// applied.
///
///     E_t(x) = sum over lights of the mean over rays of  L / pdf * F_t(eta, cos_i) * cos_i * V
///
/// Area lights get settings.light_samples rays a sample from an Owen-scrambled low-discrepancy
/// sequence of the sample's own; point-like lights one. A half-space takes light only within its
/// radius, which is where its samples are.
///
/// Units    W/mm^2 per channel.
/// Source   [JB02] section 3 (sampling the irradiance); [JMLH01] eq. 6 for the F_t weight.
std::vector<GroupIrradiance> gather_irradiance(const Scene& scene, const RayScene& rays,
                                               const SurfaceSamples& samples, float eta,
                                               Progress& progress);

/// Samples are gathered in blocks of so many, all their rays together.
inline constexpr std::size_t kGatherBlock = 64;

/// The same for samples [first, last) only, added to `groups`, which hold all samples and zeros
/// there. Both ends are multiples of kGatherBlock, or the end of the samples: the result does not
/// depend on how the samples are cut.
void gather_irradiance_range(const Scene& scene, const RayScene& rays,
                             const SurfaceSamples& samples, float eta, std::size_t first,
                             std::size_t last, std::vector<GroupIrradiance>& groups,
                             Progress& progress);

}  // namespace tallow
