// SPDX-License-Identifier: Apache-2.0
#include "common/scene/lights_yaml.h"

#include <fmt/format.h>

#include <cmath>
#include <unordered_map>

namespace tallow {
namespace {

constexpr Range kConeAngle{0, 180, "an angle in (0, 180) degrees", true, true};
constexpr float kDefaultInnerCone = 0.8f;  // of the cone; chosen: a soft but visible edge

LightShape read_point(const YamlMap& map, const LengthReader& lengths) {
    map.allow_only({"type", "group", "position", "intensity"});
    return PointLight{lengths.point(map, "position"), map.rgb("intensity", kRadiometric)};
}

LightShape read_directional(const YamlMap& map, const LengthReader&) {
    map.allow_only({"type", "group", "direction", "irradiance"});
    return DirectionalLight{read_direction(map, "direction"), map.rgb("irradiance", kRadiometric)};
}

Vec3 read_spot_axis(const YamlMap& map, const LengthReader& lengths) {
    if (map.has("look_at") && map.has("direction"))
        fail_at(map.find("direction")->key_where, "direction",
                "cannot be given together with 'look_at'");
    if (map.has("direction")) return read_direction(map, "direction");
    if (!map.has("look_at")) fail_at(map.where(), "", "missing key 'look_at' or 'direction'");
    return read_forward(map, lengths);
}

LightShape read_spot(const YamlMap& map, const LengthReader& lengths) {
    map.allow_only({"type", "group", "position", "look_at", "direction", "intensity", "cone_deg",
                    "inner_deg"});
    const float cone_deg = map.number("cone_deg", kConeAngle);
    const Range inside_cone{0, cone_deg, "an angle in [0, cone_deg) degrees", false, true};
    const float inner_deg = map.number_or("inner_deg", inside_cone, kDefaultInnerCone * cone_deg);
    SpotLight light;
    light.position = lengths.point(map, "position");
    light.direction = read_spot_axis(map, lengths);
    light.intensity = map.rgb("intensity", kRadiometric);
    light.cos_inner = std::cos(glm::radians(inner_deg / 2));
    light.cos_outer = std::cos(glm::radians(cone_deg / 2));
    // The step between the two divides by their difference.
    if (!(light.cos_inner > light.cos_outer))
        map.fail("cone_deg", "expected a cone wide enough for a soft edge");
    return light;
}

LightShape read_quad(const YamlMap& map, const LengthReader& lengths) {
    map.allow_only({"type", "group", "position", "look_at", "up", "size", "radiance"});
    const View view = read_view(map, lengths);
    const auto& size = yaml_items(map.at("size"), "size", 2, "two numbers [width, height]");
    const Vec3 right = glm::normalize(glm::cross(view.forward, view.up));
    QuadLight light;
    light.center = view.position;
    light.normal = view.forward;
    light.u = right * lengths.positive(size[0], "size");
    light.v = glm::cross(right, view.forward) * lengths.positive(size[1], "size");
    light.radiance = map.rgb("radiance", kRadiometric);
    return light;
}

LightShape read_sphere(const YamlMap& map, const LengthReader& lengths) {
    map.allow_only({"type", "group", "position", "radius", "radiance"});
    return SphereLight{lengths.point(map, "position"), lengths.positive(map, "radius"),
                       map.rgb("radiance", kRadiometric)};
}

LightShape read_environment(const YamlMap& map, const LengthReader&) {
    map.allow_only({"type", "group", "radiance"});
    return EnvironmentLight{map.rgb("radiance", kRadiometric)};
}

/// Name -> index into scene.groups; a name's first appearance makes a group.
class GroupIndex {
public:
    explicit GroupIndex(std::vector<LightGroup>& groups) : groups_(groups) {}

    std::uint32_t read(const YamlMap& map) {
        const std::string name = map.has("group") ? map.text("group") : "default";
        if (map.has("group")) require_name(map.at("group").where, name);
        const auto next = static_cast<std::uint32_t>(groups_.size());
        const auto [entry, is_new] = index_.emplace(name, next);
        if (is_new) groups_.push_back({name});
        return entry->second;
    }

private:
    std::vector<LightGroup>& groups_;
    std::unordered_map<std::string, std::uint32_t> index_;
};

}  // namespace

void read_lights(const std::vector<YamlNode>& section, const LengthReader& lengths, Scene& scene) {
    using Reader = LightShape (*)(const YamlMap&, const LengthReader&);
    GroupIndex groups(scene.groups);
    const YamlNode* environment = nullptr;
    for (const YamlNode& node : section) {
        const YamlMap map(node, fmt::format("lights.{}", scene.lights.size()));
        const auto read = map.choice<Reader>("type", {{"point", read_point},
                                                      {"directional", read_directional},
                                                      {"spot", read_spot},
                                                      {"quad", read_quad},
                                                      {"sphere", read_sphere},
                                                      {"environment", read_environment}});
        scene.lights.push_back({read(map, lengths), groups.read(map)});
        if (!std::holds_alternative<EnvironmentLight>(scene.lights.back().shape)) continue;
        if (environment)
            fail_at(node.where, "",
                    "expected one environment, got a second; the first is at " +
                        environment->where.text());
        environment = &node;
    }
}

void read_groups(const YamlNode& section, Scene& scene) {
    std::unordered_map<std::string, LightGroup*> groups;
    std::vector<std::string_view> names;
    for (LightGroup& group : scene.groups) {
        groups.emplace(group.name, &group);
        names.push_back(group.name);
    }
    for (const YamlEntry& entry : YamlMap(section, "groups").entries()) {
        const auto group = groups.find(entry.key);
        if (group == groups.end())
            fail_at(entry.key_where, "groups",
                    fmt::format("expected the group of a light{}, got '{}'",
                                names.empty() ? "" : ", " + one_of(names), printable(entry.key)));
        const YamlMap map(entry.value, entry.key);
        map.allow_only({"scale"});
        group->second->scale = map.rgb_or("scale", kNonNegative, Rgb(1));
    }
}

}  // namespace tallow
