// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/cli.h"
#include "common/scene/scene.h"

namespace tallow {

/// The flags of tallow-view, as given.
struct ViewOptions {
    std::filesystem::path scene;
    std::optional<std::filesystem::path> cache, screenshots, log, script;
    std::vector<std::string> overrides;
    std::string camera, output;
    std::optional<double> tolerance;
    std::optional<int> samples, frames;
};

void declare(CommandLine& line, ViewOptions& options);

/// Refuses flags that do not go together. Throws UsageError.
void require_consistent(const ViewOptions& options);

/// The camera that is asked for, as it stands in frame 0. Throws UsageError.
Camera first_camera(const ViewOptions& options, const Scene& scene);

/// The file of --cache, or SCENE.tallow beside the scene.
std::filesystem::path cache_file(const ViewOptions& options);

}  // namespace tallow
