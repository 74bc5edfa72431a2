// SPDX-License-Identifier: Apache-2.0
#include "common/scene/presets.h"

#include <algorithm>
#include <string_view>

#include "common/scene/materials_yaml.h"
#include "common/scene/yaml_map.h"

namespace tallow {

extern const std::string_view kMaterialsYaml;  // data/materials.yaml, see cmake/embed_text.cmake

namespace {

// [NGD06] table 2: the unit of its coefficients in 1/mm, and the tank that the liquids went into.
constexpr float kTableUnit = 1e-2f;
constexpr float kTankMillilitres = 23000;

Preset read_coefficients(const std::string& name, const YamlMap& map) {
    map.allow_only({"sigma_s_prime", "sigma_a", "eta", "printed_reflectance", "source"});
    return {name, read_medium(map), map.rgb("printed_reflectance", kZeroToOne), map.text("source")};
}

/// Mean over the channels that scatter: the others have no phase function to average.
float mean_cosine(Rgb g, Rgb scattering) {
    float sum = 0;
    int count = 0;
    for (int c = 0; c < 3; ++c)
        if (scattering[c] > 0) sum += g[c], ++count;
    return count == 0 ? 0 : sum / float(count);
}

Preset read_diluted(const std::string& name, const YamlMap& map) {
    map.allow_only({"absorption", "scattering", "g", "volume_ml", "eta", "source"});
    const float undiluted = kTableUnit * kTankMillilitres / map.number("volume_ml", kPositive);
    const Rgb scattering = map.rgb("scattering", kNonNegative), g = map.rgb("g", kZeroToOne);
    Medium medium;
    medium.sigma_a = undiluted * map.rgb("absorption", kNonNegative);
    medium.sigma_s_prime = undiluted * (Rgb(1) - g) * scattering;
    medium.g = mean_cosine(g, scattering);
    medium.eta = map.number("eta", kPositive);
    return {name, medium, std::nullopt, map.text("source"), true};
}

std::vector<Preset> parse_presets() {
    std::vector<Preset> result;
    const YamlNode table = parse_yaml(kMaterialsYaml, "data/materials.yaml");
    for (const YamlEntry& entry : YamlMap(table, "presets").entries()) {
        const YamlMap map(entry.value, entry.key);
        result.push_back(map.has("volume_ml") ? read_diluted(entry.key, map)
                                              : read_coefficients(entry.key, map));
    }
    std::ranges::sort(result, {}, &Preset::name);
    return result;
}

}  // namespace

const std::vector<Preset>& presets() {
    static const std::vector<Preset> table = parse_presets();
    return table;
}

const Preset* find_preset(const std::string& name) {
    const auto found = std::ranges::find(presets(), name, &Preset::name);
    return found == presets().end() ? nullptr : &*found;
}

std::vector<std::string> preset_names() {
    std::vector<std::string> names;
    for (const Preset& preset : presets()) names.push_back(preset.name);
    return names;
}

std::vector<std::string> dilutable_preset_names() {
    std::vector<std::string> names;
    for (const Preset& preset : presets())
        if (preset.dilutable) names.push_back(preset.name);
    return names;
}

Medium diluted(Medium medium, float share) {
    medium.sigma_a *= share;
    medium.sigma_s_prime *= share;
    return medium;
}

}  // namespace tallow
