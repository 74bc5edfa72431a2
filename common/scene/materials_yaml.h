// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/scene/geometry_yaml.h"
#include "common/scene/scene.h"
#include "common/scene/textures_yaml.h"
#include "common/scene/yaml_map.h"

namespace tallow {

/// Optical coefficients of a medium: sigma_a with sigma_s_prime, or with sigma_s and g; eta.
/// Throws fail_at() for what is missing, contradicts itself or is outside of Medium's domain.
Medium read_medium(const YamlMap& map);

/// The `materials` section: a map from name to material, in file order. `lengths` converts the mean
/// free paths; coefficients are in 1/mm in every scene. `textures` are those that it may name.
std::vector<Material> read_materials(const YamlNode& section, const LengthReader& lengths,
                                     const std::vector<NamedTexture>& textures);

}  // namespace tallow
