// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "common/scene/yaml_tree.h"

namespace tallow {

/// Changes one value of a scene's tree as --set KEY=VALUE asks; load_scene() says what KEY and
/// VALUE are. What is set remembers that it came from a flag, and so do errors about it later.
///
/// Throws   UsageError "--set materials.wex.eta: materials has no 'wex', did you mean 'wax'?"
void apply_override(YamlNode& root, const std::string& key_and_value);

}  // namespace tallow
