// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/scene.h"

namespace tallow {

/// Reads and validates a scene file (YAML, and therefore JSON).
///
/// `overrides` are KEY=VALUE as given to --set, applied in order before anything is judged: KEY
/// walks the file's maps by name and its lists by index (`materials.wax.sigma_a`,
/// `lights.0.radiance`, `groups.key.scale`), VALUE is YAML. The maps and lists on the way must
/// exist, save for `groups`, its groups, and `settings`; the last key may be new to its map.
///
/// Throws   InputError "scene.yaml:2:10: sigma_a: expected a number >= 0, got '-0.1'";
///          UsageError "--set materials.wax.sigma_a: expected a number >= 0, got '-0.1'" for an
///          override that cannot be applied, or whose value is wrong.
Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

/// The same for a text that is in memory, as if it stood in `file`.
Scene parse_scene(std::string_view text, const std::filesystem::path& file,
                  const std::vector<std::string>& overrides = {});

}  // namespace tallow
