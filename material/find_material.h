// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "common/scene/scene.h"

namespace tallow {

/// A translucent material and where it comes from.
struct FoundMaterial {
    std::string name;    // "marble"
    std::string origin;  // "preset, [JMLH01]", or the scene's file
    SubsurfaceMaterial material;
    bool dilutable = false;  // whether `material` is an undiluted liquid
};

/// Looks up what a command line names: PRESET, or SCENE:NAME for a material of a scene file.
///
/// Throws   UsageError listing the names there are; InputError for a scene that is wrong.
FoundMaterial find_material(const std::string& text);

}  // namespace tallow
