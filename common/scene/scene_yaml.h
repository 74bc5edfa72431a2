// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/scene/scene.h"

namespace tallow {

/// Reads and validates a scene file (YAML, and therefore JSON).
///
/// `overrides` are KEY=VALUE as given to --set: KEY walks the file's maps by name and its lists by
/// index (`materials.wax.sigma_a`, `lights.0.radiance`, `groups.key.scale`), VALUE is YAML. The
/// last map or list on the way must exist; its last key may be new.
///
/// Throws   InputError "scene.yaml:2:10: sigma_a: expected a number >= 0, got '-0.1'";
///          UsageError for an override that cannot be applied.
Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

}  // namespace tallow
