// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "common/scene/scene.h"

namespace tallow {

/// The camera as a section `cameras` of the scene's file, in its unit and about its origin, with
/// one entry of the given name: the entry can be pasted among those that are there. Read again, it
/// is the same camera, but for rounding where the unit is not mm.
std::string camera_text(const Scene& scene, const Camera& camera, const std::string& name);

}  // namespace tallow
