// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/ray_scene.h"
#include "common/scene/scene.h"
#include "precompute/gather_irradiance.h"
#include "precompute/sample_surface.h"

namespace tallow {

/// What a body's albedo leaves of the light that enters at each of its samples: the mean of
/// surface_tint() over the sample's cell.
///
/// With a texture that is the mean over 4 x 4 points: those of a square of the cell's area in its
/// tangent plane, moved onto the body along the normal by rays. So they know seams, folds and
/// clusters of small triangles as pass two does, and need to know nothing of how cells are cut.
/// Points that miss the body or meet its other side are left out.
///
/// Error    the square is not the cell: on a checker whose squares are 8 (2, 1) samples wide, the
///          tint of single samples is off by 0.06 (0.15, 0.17) RMS, their mean by KEEP.
std::vector<Rgb> entry_tints(const Scene& scene, const RayScene& rays, std::uint32_t object,
                             const SurfaceSamples& samples);

/// Multiplies E_t of all groups with entry_tints(). Does nothing for a body of albedo 1.
void tint_irradiance(const Scene& scene, const RayScene& rays, std::uint32_t object,
                     const SurfaceSamples& samples, std::span<GroupIrradiance> groups);

}  // namespace tallow
