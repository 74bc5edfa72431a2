// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/optics/medium.h"

namespace tallow {

/// The measured media of data/materials.yaml, by lower-case name ("marble", "skimmilk").
/// The table is compiled into the library, so that programs need no data folder.
std::optional<Medium> find_preset(const std::string& name);

/// Names of all presets, sorted.
std::vector<std::string> preset_names();

}  // namespace tallow
