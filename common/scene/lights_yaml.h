// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "common/scene/geometry_yaml.h"
#include "common/scene/scene.h"

namespace tallow {

/// The `lights` section, a list. Appends to scene.lights, and to scene.groups the groups that they
/// name, in order of first appearance; a light that names none belongs to the group "default".
/// Files are looked up in `folder` and read.
void read_lights(const std::vector<YamlNode>& section, const LengthReader& lengths,
                 const std::filesystem::path& folder, Scene& scene);

/// The `groups` section: a map from the name of a group in scene.groups to its scale.
void read_groups(const YamlNode& section, Scene& scene);

}  // namespace tallow
