// SPDX-License-Identifier: Apache-2.0
// Scene file -> Scene. This file reads the sections that are short; cameras, materials, objects
// and lights have files of their own. Everything is validated here, once: behind it nobody asks
// again.
#include "common/scene/scene_yaml.h"

#include "common/scene/cameras_yaml.h"
#include "common/scene/geometry_yaml.h"
#include "common/scene/lights_yaml.h"
#include "common/scene/materials_yaml.h"
#include "common/scene/objects_yaml.h"
#include "common/scene/yaml_map.h"
#include "common/scene/yaml_override.h"

namespace tallow {
namespace {

constexpr int kMostBounces = 64;      // of light between surfaces
constexpr int kLargestCount = 65536;  // of samples

float read_unit(const YamlMap& scene) {
    return scene.choice_or("unit", {{"mm", 1.0f}, {"cm", 10.0f}, {"m", 1000.0f}}, 1.0f);
}

// Nothing where the key is absent or says auto.
std::optional<int> count_or_auto(const YamlMap& settings, std::string_view key, int low, int high) {
    if (!settings.has(key)) return std::nullopt;
    const YamlNode& node = settings.at(key);
    if (node.kind == YamlNode::Kind::scalar && node.text == "auto") return std::nullopt;
    return yaml_integer(node, key, low, high);
}

Settings read_settings(const YamlNode& section) {
    constexpr Range kTolerance{0, 1, "a number in [0, 1)", false, true};
    const YamlMap map(section, "settings");
    map.allow_only({"tolerance", "samples", "light_samples", "bounces", "indirect_samples",
                    "single_scattering_depths", "plan"});
    Settings settings;
    settings.tolerance = map.number_or("tolerance", kTolerance, settings.tolerance);
    settings.samples = map.integer_or("samples", 1, kLargestCount, settings.samples);
    settings.light_samples = count_or_auto(map, "light_samples", 1, kLargestCount);
    settings.bounces = count_or_auto(map, "bounces", 0, kMostBounces);
    settings.indirect_samples = count_or_auto(map, "indirect_samples", 1, kLargestCount);
    settings.single_scattering_depths =
        count_or_auto(map, "single_scattering_depths", 1, kLargestCount);
    settings.everything = map.choice_or("plan", {{"auto", false}, {"everything", true}}, false);
    return settings;
}

Scene read_scene(YamlNode root, const std::filesystem::path& file,
                 const std::vector<std::string>& overrides) {
    for (const std::string& override_text : overrides) apply_override(root, override_text);

    const YamlMap map(root, "scene");
    map.allow_only(
        {"unit", "cameras", "textures", "materials", "objects", "lights", "groups", "settings"});
    Scene scene;
    scene.file = file;
    scene.mm_per_unit = read_unit(map);
    LengthReader lengths{scene.mm_per_unit};
    std::vector<NamedTexture> textures;
    if (map.has("textures"))
        textures = read_textures(map.at("textures"), file.parent_path(), lengths);
    if (map.has("materials"))
        scene.materials = read_materials(map.at("materials"), lengths, textures);
    if (map.has("objects")) {
        PlacedObjects placed =
            read_objects(map.list("objects"), scene.materials, file.parent_path(), lengths);
        scene.objects = std::move(placed.objects);
        scene.origin = lengths.origin = placed.origin;
    }
    scene.cameras = read_cameras(map.at("cameras"), lengths);
    if (map.has("lights")) read_lights(map.list("lights"), lengths, file.parent_path(), scene);
    if (map.has("groups")) read_groups(map.at("groups"), scene);
    if (map.has("settings")) scene.settings = read_settings(map.at("settings"));
    return scene;
}

}  // namespace

Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
    return read_scene(read_yaml(file), file, overrides);
}

Scene parse_scene(std::string_view text, const std::filesystem::path& file,
                  const std::vector<std::string>& overrides) {
    return read_scene(parse_yaml(text, file.string()), file, overrides);
}

}  // namespace tallow
