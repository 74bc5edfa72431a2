// SPDX-License-Identifier: Apache-2.0
#include "common/scene/presets.h"

#include <algorithm>
#include <string_view>

#include "common/scene/materials_yaml.h"
#include "common/scene/yaml_map.h"

namespace tallow {

extern const std::string_view kMaterialsYaml;  // data/materials.yaml, see cmake/embed_text.cmake

namespace {

std::vector<Preset> parse_presets() {
    std::vector<Preset> result;
    const YamlNode table = parse_yaml(kMaterialsYaml, "data/materials.yaml");
    for (const YamlEntry& entry : YamlMap(table, "presets").entries()) {
        const YamlMap map(entry.value, entry.key);
        map.allow_only({"sigma_s_prime", "sigma_a", "eta", "printed_reflectance", "source"});
        result.push_back({entry.key, read_medium(map), map.rgb("printed_reflectance", kZeroToOne),
                          map.text("source")});
    }
    std::ranges::sort(result, {}, &Preset::name);
    return result;
}

}  // namespace

const std::vector<Preset>& presets() {
    static const std::vector<Preset> table = parse_presets();
    return table;
}

std::optional<Medium> find_preset(const std::string& name) {
    const auto found = std::ranges::find(presets(), name, &Preset::name);
    if (found == presets().end()) return std::nullopt;
    return found->medium;
}

std::vector<std::string> preset_names() {
    std::vector<std::string> names;
    for (const Preset& preset : presets()) names.push_back(preset.name);
    return names;
}

}  // namespace tallow
