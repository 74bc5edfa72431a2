// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/scene/camera.h"
#include "common/scene/geometry_yaml.h"

namespace tallow {

/// The section `cameras`: at least one, each of which can be looked through in all of its frames.
/// Throws as load_scene() does.
std::vector<Camera> read_cameras(const YamlNode& section, const LengthReader& lengths);

}  // namespace tallow
