// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "common/cloud/cache_io.h"

namespace tallow {

/// What a cache holds, for people: size, fingerprint, groups, and for each body counts, area,
/// bounding box and area-weighted mean irradiance. Many lines, each ended by '\n'.
std::string describe_cache(const MappedCache& cache);

/// Writes the samples of all bodies as one binary PLY for MeshLab, Blender and the like. Each
/// vertex has
///
///     float x y z, nx ny nz      mm, 1
///     float area                 mm^2
///     float irradiance_r/g/b     W/mm^2, E_t summed over the light groups, direct and indirect,
///     group scales not applied uchar red green blue       the same divided by its 99th percentile,
///     sRGB int   body index in the cache
///
/// Throws OutputError.
void export_ply(const std::filesystem::path& file, const CacheView& cache);

}  // namespace tallow
