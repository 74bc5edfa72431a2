// SPDX-License-Identifier: Apache-2.0
#include "common/scene/materials_yaml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ranges>
#include <tuple>

#include "common/optics/invert_medium.h"
#include "common/scene/presets.h"

namespace tallow {
namespace {

using MaterialKind = decltype(Material::kind);
using ModelName = decltype(kModels)::value_type;

/// What reading one material needs besides its map.
struct Context {
    const LengthReader& lengths;
    const std::vector<NamedTexture>& textures;
};

constexpr const char* kChannels[] = {"red", "green", "blue"};

// Glass to air is 1.5, diamond 2.4. Below 1 the boundary would reflect totally from outside, which
// the dipole's boundary condition does not describe.
constexpr Range kIndex{1, 3, "a relative index in [1, 3]"};
constexpr Range kMeanCosine{-1, 1, "a number in (-1, 1)", true, true};

// A kilometre of mean free path; chosen to keep the cubes of dipole depths far from overflow.
constexpr float kSmallestExtinction = 1e-6f;  // 1/mm

void refuse_together(const YamlMap& map, std::string_view key, std::string_view other) {
    if (map.has(key) && map.has(other))
        fail_at(map.find(key)->key_where, key,
                fmt::format("cannot be given together with '{}'", other));
}

/// Refuses a key that means nothing without another.
void refuse_alone(const YamlMap& map, std::string_view key, std::string_view other) {
    if (map.has(key) && !map.has(other))
        fail_at(map.find(key)->key_where, key, fmt::format("needs '{}' beside it", other));
}

void require_extinction(const YamlMap& map, const Medium& medium) {
    for (int c = 0; c < 3; ++c)
        if (medium.sigma_t_prime()[c] < kSmallestExtinction)
            map.fail("sigma_a",
                     fmt::format("expected sigma_a + sigma_s_prime >= {:g} in each "
                                 "channel, got {:g} in {}",
                                 kSmallestExtinction, medium.sigma_t_prime()[c], kChannels[c]));
}

const Preset& known_preset(const YamlMap& map) {
    if (const Preset* preset = find_preset(map.text("preset"))) return *preset;
    fail_expected(map.at("preset"), "preset",
                  fmt::format("one of {}", fmt::join(preset_names(), ", ")));
}

Medium read_preset(const YamlMap& map) {
    constexpr Range kShare{0, 1, "a share in (0, 1]", true};
    for (const char* key : {"sigma_a", "sigma_s_prime", "sigma_s"})
        refuse_together(map, key, "preset");
    const Preset& preset = known_preset(map);
    Medium medium = preset.medium;
    if (map.has("dilution")) {
        if (!preset.dilutable)
            fail_at(map.find("dilution")->key_where, "dilution",
                    fmt::format("'{}' cannot be diluted, expected one of the liquids {}",
                                preset.name, fmt::join(dilutable_preset_names(), ", ")));
        medium = diluted(medium, map.number("dilution", kShare));
        if (min_channel(medium.sigma_t_prime()) < kSmallestExtinction)
            map.fail("dilution",
                     fmt::format("expected a mixture with sigma_a + sigma_s_prime >= "
                                 "{:g}, got {:g}",
                                 kSmallestExtinction, min_channel(medium.sigma_t_prime())));
    }
    medium.eta = map.number_or("eta", kIndex, medium.eta);
    medium.g = map.number_or("g", kMeanCosine, medium.g);
    return medium;
}

Rgb read_mean_free_path(const YamlMap& map, const LengthReader& lengths) {
    constexpr std::string_view kKey = "mean_free_path";
    const YamlNode& node = map.at(kKey);
    const auto read = [&](const YamlNode& item) {
        const float length = lengths.positive(item, kKey);
        if (length > 1 / kSmallestExtinction)
            fail_expected(item, kKey, fmt::format("at most {:g} mm", 1 / kSmallestExtinction));
        return length;
    };
    if (node.kind == YamlNode::Kind::scalar) return Rgb(read(node));
    const auto& items = yaml_items(node, kKey, 3, "a number or three [r, g, b]");
    return {read(items[0]), read(items[1]), read(items[2])};
}

/// The medium whose total reflectance under `model` is diffuse_color.
Medium read_artistic(const YamlMap& map, Model model, const LengthReader& lengths) {
    for (const char* key : {"preset", "sigma_a", "sigma_s_prime", "sigma_s"})
        refuse_together(map, key, "diffuse_color");
    const Rgb color = map.rgb("diffuse_color", kZeroToOne);
    const Rgb mean_free_path = read_mean_free_path(map, lengths);
    Medium medium;
    medium.eta = map.number("eta", kIndex);
    medium.g = map.number_or("g", kMeanCosine, 0);
    for (int c = 0; c < 3; ++c) {
        const auto absorbed = invert_reflectance(model, double(color[c]), medium.eta, medium.g);
        if (!absorbed)
            map.fail("diffuse_color",
                     fmt::format("expected at most {:.4f}, which model '{}' reflects without any "
                                 "absorption at eta {:g}, got {:g} in {}",
                                 largest_reflectance(model, medium.eta, medium.g),
                                 std::ranges::find(kModels, model, &ModelName::second)->first,
                                 medium.eta, color[c], kChannels[c]));
        const auto k = channel_coefficients(*absorbed, double(mean_free_path[c]));
        medium.sigma_a[c] = k.sigma_a, medium.sigma_s_prime[c] = k.sigma_s_prime;
    }
    return medium;
}

Model read_model(const YamlMap& map) {
    if (!map.has("model")) return Model::body_aware;
    const YamlNode& node = map.at("model");
    const auto found = std::ranges::find(kModels, std::string_view(node.text), &ModelName::first);
    if (node.kind != YamlNode::Kind::scalar || found == kModels.end())
        fail_expected(node, "model",
                      fmt::format("one of {}", fmt::join(kModels | std::views::keys, ", ")));
    return found->second;
}

Medium read_any_medium(const YamlMap& map, Model model, const LengthReader& lengths) {
    if (map.has("diffuse_color")) return read_artistic(map, model, lengths);
    refuse_alone(map, "mean_free_path", "diffuse_color");
    if (map.has("preset")) return read_preset(map);
    refuse_alone(map, "dilution", "preset");
    if (!map.has("sigma_a"))
        fail_at(map.where(), "", "missing key 'preset', 'sigma_a' or 'diffuse_color'");
    return read_medium(map);
}

Switch read_switch(const YamlMap& map, const char* key) {
    return map.choice_or(key,
                         {{"auto", Switch::automatic}, {"on", Switch::on}, {"off", Switch::off}},
                         Switch::automatic);
}

std::pair<Switch, Connection> read_single_scattering(const YamlMap& map) {
    constexpr std::pair kAuto(Switch::automatic, Connection::exact);
    constexpr std::pair kExact(Switch::on, Connection::exact);
    return map.choice_or("single_scattering",
                         {{"auto", kAuto},
                          {"on", kExact},
                          {"off", std::pair(Switch::off, Connection::exact)},
                          {"straight", std::pair(Switch::on, Connection::straight)},
                          {"exact", kExact}},
                         kAuto);
}

MaterialKind read_subsurface(const YamlMap& map, const Context& context) {
    map.allow_only({"type",          "preset",         "dilution",
                    "sigma_a",       "sigma_s_prime",  "sigma_s",
                    "diffuse_color", "mean_free_path", "g",
                    "eta",           "model",          "single_scattering",
                    "exit",          "surface",        "albedo",
                    "diffuse_limit", "shifts",         "boundary_elements",
                    "re_entry",      "transmission"});
    SubsurfaceMaterial material;
    use_model(material, read_model(map));
    material.medium = read_any_medium(map, material.model, context.lengths);
    // One choice so far; read all the same, so that a scene made for another is not misread.
    map.choice_or("surface", {{"smooth", 0}}, 0);
    material.exit = map.choice_or("exit",
                                  {{"normalized", Exit::normalized},
                                   {"classic", Exit::classic},
                                   {"directional", Exit::directional}},
                                  material.exit);
    material.shifts = map.choice_or("shifts", {{"on", true}, {"off", false}}, material.shifts);
    material.boundary_elements = map.choice_or("boundary_elements", {{"on", true}, {"off", false}},
                                               material.boundary_elements);
    material.re_entry =
        map.choice_or("re_entry", {{"on", true}, {"off", false}}, material.re_entry);
    material.diffuse_limit = read_switch(map, "diffuse_limit");
    material.transmission = read_switch(map, "transmission");
    std::tie(material.single_scattering, material.connection) = read_single_scattering(map);
    if (map.has("albedo")) material.albedo = read_surface_color(map, "albedo", context.textures);
    return material;
}

MaterialKind read_diffuse(const YamlMap& map, const Context& context) {
    map.allow_only({"type", "reflectance"});
    return DiffuseMaterial{read_surface_color(map, "reflectance", context.textures)};
}

MaterialKind read_plastic(const YamlMap& map, const Context& context) {
    map.allow_only({"type", "reflectance", "eta"});
    return PlasticMaterial{read_surface_color(map, "reflectance", context.textures),
                           map.number_or("eta", kIndex, 1.5f)};
}

MaterialKind read_mirror(const YamlMap& map, const Context&) {
    map.allow_only({"type", "reflectance"});
    return MirrorMaterial{map.rgb_or("reflectance", kZeroToOne, Rgb(1))};
}

}  // namespace

Medium read_medium(const YamlMap& map) {
    refuse_together(map, "sigma_s", "sigma_s_prime");
    Medium medium;
    medium.sigma_a = map.rgb("sigma_a", kNonNegative);
    medium.g = map.number_or("g", kMeanCosine, 0);
    medium.sigma_s_prime = map.has("sigma_s") ? (1 - medium.g) * map.rgb("sigma_s", kNonNegative)
                                              : map.rgb("sigma_s_prime", kNonNegative);
    medium.eta = map.number("eta", kIndex);
    require_extinction(map, medium);
    return medium;
}

std::vector<Material> read_materials(const YamlNode& section, const LengthReader& lengths,
                                     const std::vector<NamedTexture>& textures) {
    using Reader = MaterialKind (*)(const YamlMap&, const Context&);
    const Context context{lengths, textures};
    std::vector<Material> materials;
    for (const YamlEntry& entry : YamlMap(section, "materials").entries()) {
        require_name(entry.key_where, entry.key);
        const YamlMap map(entry.value, entry.key);
        const auto read = map.choice<Reader>("type", {{"subsurface", read_subsurface},
                                                      {"diffuse", read_diffuse},
                                                      {"plastic", read_plastic},
                                                      {"mirror", read_mirror}});
        materials.push_back({entry.key, read(map, context)});
    }
    return materials;
}

}  // namespace tallow
