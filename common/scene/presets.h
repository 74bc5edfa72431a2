// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/rgb.h"
#include "common/optics/medium.h"

namespace tallow {

/// A measured medium of data/materials.yaml.
struct Preset {
    std::string name;  // lower case: "marble", "skimmilk"
    Medium medium;
    Rgb printed_reflectance;  // diffuse reflectance as the source prints it, in linear RGB
    std::string source;       // key of docs/REFERENCES.md
};

/// All presets, sorted by name. The table is compiled into the library, so that programs need no
/// data folder.
const std::vector<Preset>& presets();

std::optional<Medium> find_preset(const std::string& name);

/// Names of all presets, sorted.
std::vector<std::string> preset_names();

}  // namespace tallow
