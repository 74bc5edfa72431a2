// SPDX-License-Identifier: Apache-2.0
#include "common/scene/lights_yaml.h"

#include <fmt/format.h>

#include <cmath>
#include <unordered_map>

#include "common/base/errors.h"
#include "common/geometry/mesh_io.h"
#include "common/geometry/mesh_repair.h"
#include "common/scene/transform_yaml.h"

namespace tallow {
namespace {

constexpr Range kConeAngle{0, 180, "an angle in (0, 180) degrees", true, true};
constexpr float kDefaultInnerCone = 0.8f;  // of the cone; chosen: a soft but visible edge

/// What reading one light needs besides its map.
struct Context {
    const LengthReader& lengths;
    const std::filesystem::path& folder;
};

/// The result of read(path) for the file that `key` names; what is wrong with it is reported there.
template <class Read>
auto read_named_file(const YamlMap& map, const char* key, const Context& context, Read&& read) {
    const std::filesystem::path file = context.folder / map.text(key);
    try {
        return read(file);
    } catch (const InputError& error) {
        map.fail(key, error.what());
    }
}

std::shared_ptr<const LightImage> read_light_image(const YamlMap& map, const char* key,
                                                   LightImage::Layout layout,
                                                   const Context& context) {
    return read_named_file(map, key, context, [&](const std::filesystem::path& file) {
        return std::make_shared<const LightImage>(read_image(file), layout);
    });
}

/// Refuses what only floats beyond those of `radiance` itself could hold.
void require_radiance(const YamlMap& map, const char* key, const LightImage& image, Rgb factor) {
    if (!(max_channel(factor) * double(image.brightest()) <= kRadiometric.high))
        map.fail(key,
                 fmt::format("expected at most {:g} altogether, got {:g} times the image's {:g}",
                             kRadiometric.high, max_channel(factor), image.brightest()));
}

LightShape read_point(const YamlMap& map, const Context& context) {
    map.allow_only({"type", "group", "position", "intensity"});
    return PointLight{context.lengths.point(map, "position"), map.rgb("intensity", kRadiometric)};
}

LightShape read_directional(const YamlMap& map, const Context&) {
    map.allow_only({"type", "group", "direction", "irradiance"});
    return DirectionalLight{read_direction(map, "direction"), map.rgb("irradiance", kRadiometric)};
}

/// The key `direction`, or the one from position to `look_at`.
Vec3 read_axis(const YamlMap& map, const LengthReader& lengths) {
    if (map.has("look_at") && map.has("direction"))
        fail_at(map.find("direction")->key_where, "direction",
                "cannot be given together with 'look_at'");
    if (map.has("direction")) return read_direction(map, "direction");
    if (!map.has("look_at")) fail_at(map.where(), "", "missing key 'look_at' or 'direction'");
    return read_forward(map, lengths);
}

LightShape read_spot(const YamlMap& map, const Context& context) {
    map.allow_only({"type", "group", "position", "look_at", "direction", "intensity", "cone_deg",
                    "inner_deg"});
    const float cone_deg = map.number("cone_deg", kConeAngle);
    const Range inside_cone{0, cone_deg, "an angle in [0, cone_deg) degrees", false, true};
    const float inner_deg = map.number_or("inner_deg", inside_cone, kDefaultInnerCone * cone_deg);
    SpotLight light;
    light.position = context.lengths.point(map, "position");
    light.direction = read_axis(map, context.lengths);
    light.intensity = map.rgb("intensity", kRadiometric);
    light.cos_inner = std::cos(glm::radians(inner_deg / 2));
    light.cos_outer = std::cos(glm::radians(cone_deg / 2));
    // The step between the two divides by their difference.
    if (!(light.cos_inner > light.cos_outer))
        map.fail("cone_deg", "expected a cone wide enough for a soft edge");
    return light;
}

LightShape read_quad(const YamlMap& map, const Context& context) {
    map.allow_only({"type", "group", "position", "look_at", "up", "size", "radiance", "texture"});
    const View view = read_view(map, context.lengths);
    const auto& size = yaml_items(map.at("size"), "size", 2, "two numbers [width, height]");
    const Vec3 right = glm::normalize(glm::cross(view.forward, view.up));
    QuadLight light;
    light.center = view.position;
    light.normal = view.forward;
    light.u = right * context.lengths.positive(size[0], "size");
    light.v = glm::cross(right, view.forward) * context.lengths.positive(size[1], "size");
    light.radiance = map.rgb("radiance", kRadiometric);
    if (map.has("texture")) {
        light.texture = read_light_image(map, "texture", LightImage::Layout::flat, context);
        require_radiance(map, "radiance", *light.texture, light.radiance);
    }
    return light;
}

LightShape read_disc(const YamlMap& map, const Context& context) {
    map.allow_only({"type", "group", "position", "look_at", "direction", "radius", "radiance"});
    return DiscLight{context.lengths.point(map, "position"), read_axis(map, context.lengths),
                     context.lengths.positive(map, "radius"), map.rgb("radiance", kRadiometric)};
}

LightShape read_sphere(const YamlMap& map, const Context& context) {
    map.allow_only({"type", "group", "position", "radius", "radiance"});
    return SphereLight{context.lengths.point(map, "position"),
                       context.lengths.positive(map, "radius"), map.rgb("radiance", kRadiometric)};
}

LightShape read_mesh(const YamlMap& map, const Context& context) {
    map.allow_only({"type", "group", "file", "transform", "radiance"});
    const LengthReader from_file_origin{context.lengths.mm_per_unit};
    const Affine to_world =
        read_transform(map, from_file_origin).relative_to(context.lengths.origin);
    const Rgb radiance = map.rgb("radiance", kRadiometric);
    const Affine to_mm{glm::mat3(context.lengths.mm_per_unit), Vec3(0)};
    return read_named_file(map, "file", context, [&](const std::filesystem::path& file) {
        RepairedMesh repaired = repair_mesh(read_polygon_soup(file), Normals::flat, file.string());
        const std::string repair = repaired.report.changed_anything()
                                       ? file.string() + ": " + repaired.report.summary()
                                       : std::string();
        TriangleMesh mesh = transform_mesh(std::move(repaired.mesh), compose(to_world, to_mm));
        return MeshLight{std::make_shared<const MeshEmitter>(std::move(mesh), repair), radiance};
    });
}

LightShape read_environment(const YamlMap& map, const Context& context) {
    map.allow_only({"type", "group", "radiance", "file", "rotate_deg", "scale"});
    if (map.has("radiance") && map.has("file"))
        fail_at(map.find("file")->key_where, "file", "cannot be given together with 'radiance'");
    if (!map.has("radiance") && !map.has("file"))
        fail_at(map.where(), "", "missing key 'radiance' or 'file'");
    if (map.has("radiance")) {
        for (const char* key : {"rotate_deg", "scale"})
            if (map.has(key))
                fail_at(map.find(key)->key_where, key, "cannot be given together with 'radiance'");
        return EnvironmentLight{map.rgb("radiance", kRadiometric)};
    }
    EnvironmentLight light;
    light.radiance = map.rgb_or("scale", kRadiometric, Rgb(1));
    light.rotation =
        float(glm::radians(std::fmod(double(map.number_or("rotate_deg", kAnyNumber, 0)), 360.0)));
    light.image = read_light_image(map, "file", LightImage::Layout::directions, context);
    require_radiance(map, map.has("scale") ? "scale" : "file", *light.image, light.radiance);
    return light;
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

void read_lights(const std::vector<YamlNode>& section, const LengthReader& lengths,
                 const std::filesystem::path& folder, Scene& scene) {
    using Reader = LightShape (*)(const YamlMap&, const Context&);
    const Context context{lengths, folder};
    GroupIndex groups(scene.groups);
    const YamlNode* environment = nullptr;
    for (const YamlNode& node : section) {
        const YamlMap map(node, fmt::format("lights.{}", scene.lights.size()));
        const auto read = map.choice<Reader>("type", {{"point", read_point},
                                                      {"directional", read_directional},
                                                      {"spot", read_spot},
                                                      {"quad", read_quad},
                                                      {"disc", read_disc},
                                                      {"sphere", read_sphere},
                                                      {"mesh", read_mesh},
                                                      {"environment", read_environment}});
        scene.lights.push_back({read(map, context), groups.read(map)});
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
