// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "common/scene/scene.h"

namespace tallow {

/// The camera that --camera names; the scene's first if the name is empty. Throws UsageError.
const Camera& find_camera(const Scene& scene, const std::string& name);

}  // namespace tallow
