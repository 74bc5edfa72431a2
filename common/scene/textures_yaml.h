// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/scene/geometry_yaml.h"
#include "common/scene/texture.h"
#include "common/scene/yaml_map.h"

namespace tallow {

struct NamedTexture {
    std::string name;
    std::filesystem::path file;  // of an image
    std::shared_ptr<const Texture> texture;
};

/// The `textures` section: a map from name to texture, in file order. Images are looked up in
/// `folder` and read. Throws InputError for what read_image refuses as well.
std::vector<NamedTexture> read_textures(const YamlNode& section,
                                        const std::filesystem::path& folder,
                                        const LengthReader& lengths);

/// A reflectance or albedo: a colour in [0, 1], or {texture: NAME, scale: COLOUR} with products in
/// [0, 1].
SurfaceColor read_surface_color(const YamlMap& map, std::string_view key,
                                const std::vector<NamedTexture>& textures);

}  // namespace tallow
