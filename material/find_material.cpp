// SPDX-License-Identifier: Apache-2.0
#include "material/find_material.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/base/errors.h"
#include "common/scene/presets.h"
#include "common/scene/scene_yaml.h"

namespace tallow {
namespace {

FoundMaterial find_in_presets(const std::string& name) {
    const Preset* preset = find_preset(name);
    if (!preset)
        throw UsageError(fmt::format("MATERIAL: expected one of {}, or SCENE:NAME, got '{}'",
                                     fmt::join(preset_names(), ", "), name));
    SubsurfaceMaterial material;
    material.medium = preset->medium;
    const std::string state = preset->dilutable ? ", undiluted" : "";
    return {name, fmt::format("preset{}, [{}]", state, preset->source), material,
            preset->dilutable};
}

FoundMaterial find_in_scene(const std::string& file, const std::string& name) {
    const Scene scene = load_scene(file);
    std::vector<std::string> names;
    for (const Material& material : scene.materials) {
        const auto* translucent = std::get_if<SubsurfaceMaterial>(&material.kind);
        if (!translucent) continue;
        if (material.name == name) return {name, file, *translucent, false};
        names.push_back(material.name);
    }
    if (names.empty())
        throw UsageError(fmt::format("MATERIAL: {} has no translucent material", file));
    throw UsageError(fmt::format("MATERIAL: expected one of {}:{{{}}}, got '{}'", file,
                                 fmt::join(names, ", "), name));
}

}  // namespace

FoundMaterial find_material(const std::string& text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos) return find_in_presets(text);
    return find_in_scene(text.substr(0, colon), text.substr(colon + 1));
}

}  // namespace tallow
