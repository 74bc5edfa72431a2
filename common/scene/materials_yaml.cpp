// SPDX-License-Identifier: Apache-2.0
#include "common/scene/materials_yaml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "common/scene/presets.h"

namespace tallow {
namespace {

using MaterialKind = decltype(Material::kind);

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

void require_extinction(const YamlMap& map, const Medium& medium) {
    constexpr std::array<const char*, 3> kChannels = {"red", "green", "blue"};
    for (int c = 0; c < 3; ++c)
        if (medium.sigma_t_prime()[c] < kSmallestExtinction)
            map.fail("sigma_a", fmt::format("expected sigma_a + sigma_s_prime >= {:g} in each "
                                            "channel, got {:g} in {}",
                                            kSmallestExtinction, medium.sigma_t_prime()[c],
                                            kChannels[static_cast<std::size_t>(c)]));
}

Medium read_preset(const YamlMap& map) {
    for (const char* key : {"sigma_a", "sigma_s_prime", "sigma_s"})
        refuse_together(map, key, "preset");
    const auto medium = find_preset(map.text("preset"));
    if (!medium)
        fail_expected(map.at("preset"), "preset",
                      fmt::format("one of {}", fmt::join(preset_names(), ", ")));
    Medium result = *medium;
    result.eta = map.number_or("eta", kIndex, medium->eta);
    result.g = map.number_or("g", kMeanCosine, medium->g);
    return result;
}

MaterialKind read_subsurface(const YamlMap& map) {
    map.allow_only({"type", "preset", "sigma_a", "sigma_s_prime", "sigma_s", "g", "eta", "model",
                    "single_scattering", "exit", "surface"});
    SubsurfaceMaterial material;
    if (!map.has("preset") && !map.has("sigma_a"))
        fail_at(map.where(), "", "missing key 'preset' or 'sigma_a'");
    material.medium = map.has("preset") ? read_preset(map) : read_medium(map);
    // One choice so far; read all the same, so that a scene made for another is not misread.
    map.choice_or("model", {{"dipole", 0}}, 0);
    map.choice_or("surface", {{"smooth", 0}}, 0);
    material.exit = map.choice_or(
        "exit", {{"normalized", Exit::normalized}, {"classic", Exit::classic}}, material.exit);
    material.single_scattering =
        map.choice_or("single_scattering",
                      {{"auto", Switch::automatic}, {"on", Switch::on}, {"off", Switch::off}},
                      material.single_scattering);
    return material;
}

MaterialKind read_diffuse(const YamlMap& map) {
    map.allow_only({"type", "reflectance"});
    return DiffuseMaterial{map.rgb("reflectance", kZeroToOne)};
}

MaterialKind read_plastic(const YamlMap& map) {
    map.allow_only({"type", "reflectance", "eta"});
    return PlasticMaterial{map.rgb("reflectance", kZeroToOne), map.number_or("eta", kIndex, 1.5f)};
}

MaterialKind read_mirror(const YamlMap& map) {
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

std::vector<Material> read_materials(const YamlNode& section) {
    using Reader = MaterialKind (*)(const YamlMap&);
    std::vector<Material> materials;
    for (const YamlEntry& entry : YamlMap(section, "materials").entries()) {
        require_name(entry.key_where, entry.key);
        const YamlMap map(entry.value, entry.key);
        const auto read = map.choice<Reader>("type", {{"subsurface", read_subsurface},
                                                      {"diffuse", read_diffuse},
                                                      {"plastic", read_plastic},
                                                      {"mirror", read_mirror}});
        materials.push_back({entry.key, read(map)});
    }
    return materials;
}

}  // namespace tallow
