// SPDX-License-Identifier: Apache-2.0
#include "common/scene/objects_yaml.h"

#include <fmt/format.h>

#include <unordered_map>

#include "common/scene/transform_yaml.h"

namespace tallow {
namespace {

/// What reading one object needs besides its map.
struct Context {
    const LengthReader& lengths;
    const std::filesystem::path& folder;
    bool is_subsurface;  // the object's material
};

Shape read_sphere(const YamlMap& map, const Context& context) {
    map.allow_only({"shape", "material", "transform", "center", "radius"});
    return SphereShape{context.lengths.positive(map, "radius")};
}

Shape read_cube(const YamlMap& map, const Context& context) {
    map.allow_only({"shape", "material", "transform", "center", "size"});
    const YamlNode& size = map.at("size");
    if (size.kind == YamlNode::Kind::scalar)
        return CubeShape{Vec3(context.lengths.positive(size, "size"))};
    const auto& items = yaml_items(size, "size", 3, "a number or three [x, y, z]");
    return CubeShape{{context.lengths.positive(items[0], "size"),
                      context.lengths.positive(items[1], "size"),
                      context.lengths.positive(items[2], "size")}};
}

Shape read_disc(const YamlMap& map, const Context& context) {
    map.allow_only({"shape", "material", "transform", "center", "normal", "radius"});
    if (context.is_subsurface)
        map.fail("shape", "a disc encloses no volume, which a subsurface material needs");
    return DiscShape{read_direction(map, "normal"), context.lengths.positive(map, "radius")};
}

Shape read_plane(const YamlMap& map, const Context& context) {
    map.allow_only({"shape", "material", "transform", "point", "normal", "radius"});
    if (map.has("radius") && !context.is_subsurface)
        map.fail("radius", "only a plane of subsurface material has a radius");
    return PlaneShape{read_direction(map, "normal"),
                      context.is_subsurface ? context.lengths.positive(map, "radius") : kInfinity};
}

Shape read_mesh(const YamlMap& map, const Context& context) {
    map.allow_only({"shape", "material", "transform", "file", "normals"});
    return MeshShape{
        context.folder / map.text("file"),
        map.choice_or("normals", {{"flat", Normals::flat}, {"smooth", Normals::smooth}},
                      Normals::automatic)};
}

/// Where the object's own origin, that of its `center` or `point`, comes to stand.
Placement read_placement(const YamlMap& map, const LengthReader& lengths) {
    const char* key = map.has("point") ? "point" : "center";
    const Placement centered{glm::dmat3(1), lengths.exact_point_or_zero(map, key)};
    return compose(read_transform(map, lengths), centered);
}

/// The middle of the box around all placements, rounded to steps of 1024 mm: the rounding keeps
/// ordinary scenes where they are, and the origin from moving with every object.
DVec3 scene_origin(const std::vector<Placement>& placements) {
    constexpr double kStep = 1024;
    if (placements.empty()) return DVec3(0);
    DVec3 low = placements[0].translation, high = low;
    for (const Placement& placement : placements) {
        low = glm::min(low, placement.translation);
        high = glm::max(high, placement.translation);
    }
    return kStep * glm::round((low + high) / 2.0 / kStep);
}

class MaterialIndex {
public:
    explicit MaterialIndex(const std::vector<Material>& materials) : materials_(materials) {
        for (std::size_t i = 0; i < materials.size(); ++i)
            index_.emplace(materials[i].name, static_cast<std::uint32_t>(i));
    }

    std::uint32_t read(const YamlMap& map) const {
        const auto found = index_.find(map.text("material"));
        if (found != index_.end()) return found->second;
        std::vector<std::string_view> names;
        for (const Material& material : materials_) names.push_back(material.name);
        fail_expected(map.at("material"), "material",
                      names.empty() ? "a name from materials, which is empty" : one_of(names));
    }

private:
    const std::vector<Material>& materials_;
    std::unordered_map<std::string, std::uint32_t> index_;
};

}  // namespace

PlacedObjects read_objects(const std::vector<YamlNode>& section,
                           const std::vector<Material>& materials,
                           const std::filesystem::path& folder, const LengthReader& lengths) {
    using Reader = Shape (*)(const YamlMap&, const Context&);
    const MaterialIndex index(materials);
    std::vector<Object> objects;
    std::vector<Placement> placements;  // [object]
    for (const YamlNode& node : section) {
        const YamlMap map(node, fmt::format("objects.{}", objects.size()));
        const auto read = map.choice<Reader>("shape", {{"sphere", read_sphere},
                                                       {"cube", read_cube},
                                                       {"plane", read_plane},
                                                       {"disc", read_disc},
                                                       {"mesh", read_mesh}});
        const std::uint32_t material = index.read(map);
        const Context context{lengths, folder,
                              std::holds_alternative<SubsurfaceMaterial>(materials[material].kind)};
        objects.push_back({read(map, context), material, {}, node.where.text()});
        placements.push_back(read_placement(map, lengths));
    }
    const DVec3 origin = scene_origin(placements);
    for (std::size_t i = 0; i < objects.size(); ++i)
        objects[i].transform = placements[i].relative_to(origin);
    return {std::move(objects), origin};
}

}  // namespace tallow
