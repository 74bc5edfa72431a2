// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "common/scene/geometry_yaml.h"
#include "common/scene/scene.h"

namespace tallow {

/// Objects and the origin to which their transforms are relative (Scene::origin).
struct PlacedObjects {
    std::vector<Object> objects;
    DVec3 origin;
};

/// The `objects` section, a list. `materials` are those that it may name; files are looked up in
/// `folder`.
PlacedObjects read_objects(const std::vector<YamlNode>& section,
                           const std::vector<Material>& materials,
                           const std::filesystem::path& folder, const LengthReader& lengths);

}  // namespace tallow
