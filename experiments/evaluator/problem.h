// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/stats.h"
#include "common/exitance/lit_samples.h"
#include "common/optics/profile.h"
#include "common/scene/scene.h"

namespace tallow {

/// The sums that tallow-render would compute for a scene with one translucent body.
struct Problem {
    std::string scene, material;  // names for tables; of a preset, its own
    SubsurfaceMaterial kind;
    Orders orders;
    LitSamples samples;
    std::array<std::vector<float>, 3> flux;  // [channel][sample] E_t * area, W
    std::vector<Vec3> points;                // of the body, seen directly, tile by tile
};

/// Loads scene and cache and finds the hits of `samples` camera rays a pixel, as tallow-render
/// does. Throws InputError and UsageError as it does, and InputError unless there is one body.
Problem load_problem(const std::filesystem::path& scene_file,
                     const std::filesystem::path& cache_file,
                     const std::vector<std::string>& overrides, int samples, Stats& stats);

/// The exact kernel of a channel.
std::unique_ptr<Profile> profile(const Problem& problem, int channel);

}  // namespace tallow
