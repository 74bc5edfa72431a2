// SPDX-License-Identifier: Apache-2.0
#include "common/scene/objects_yaml.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <unordered_map>

namespace tallow {
namespace {

/// Affine in double: where an object stands, before the origin is known.
struct Placement {
    glm::dmat3 linear{1.0};
    DVec3 translation{0.0};

    DVec3 point(DVec3 p) const { return linear * p + translation; }
};

Placement compose(const Placement& outer, const Placement& inner) {
    return {outer.linear * inner.linear, outer.point(inner.translation)};
}

/// What reading one object needs besides its map.
struct Context {
    const LengthReader& lengths;
    const std::filesystem::path& folder;
    bool is_subsurface;  // the object's material
};

constexpr Range kScale{-1e6f, 1e6f, "a factor of magnitude in [1e-06, 1e+06]"};

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

float read_scale_factor(const YamlNode& node) {
    const float factor = yaml_number(node, "scale", kScale);
    // The lower bound keeps determinants of a few steps far from underflow.
    if (std::abs(factor) < 1e-6f) fail_expected(node, "scale", kScale.text);
    return factor;
}

Placement read_scale(const YamlMap& map, const LengthReader&) {
    const YamlNode& node = map.at("scale");
    constexpr const char* kExpected = "a number > 0 or three [x, y, z]";
    Vec3 factors;
    if (node.kind == YamlNode::Kind::scalar) {
        factors = Vec3(read_scale_factor(node));
        if (factors.x < 0) fail_expected(node, "scale", kExpected);
    } else {
        const auto& items = yaml_items(node, "scale", 3, kExpected);
        factors = {read_scale_factor(items[0]), read_scale_factor(items[1]),
                   read_scale_factor(items[2])};
    }
    return {glm::dmat3(factors.x, 0, 0, 0, factors.y, 0, 0, 0, factors.z), DVec3(0)};
}

Placement read_rotation(const YamlMap& map, const LengthReader&) {
    const auto& items =
        yaml_items(map.at("rotate_deg"), "rotate_deg", 4, "four numbers [x, y, z, degrees]");
    glm::dvec4 v;
    for (int i = 0; i < 4; ++i)
        v[i] = yaml_number(items[static_cast<std::size_t>(i)], "rotate_deg", kAnyNumber);
    if (DVec3(v) == DVec3(0)) map.fail("rotate_deg", "expected an axis, got a vector of length 0");
    const glm::dmat4 rotation =
        glm::rotate(glm::dmat4(1), glm::radians(v.w), glm::normalize(DVec3(v)));
    return {glm::dmat3(rotation), DVec3(0)};
}

Placement read_translation(const YamlMap& map, const LengthReader& lengths) {
    return {glm::dmat3(1), lengths.exact_point(map, "translate")};
}

/// One step of a transform: a map of a single key.
Placement read_step(const YamlNode& node, const LengthReader& lengths) {
    const YamlMap map(node, "transform");
    map.allow_only({"scale", "rotate_deg", "translate"});
    if (map.entries().size() != 1)
        fail_at(node.where, "transform",
                fmt::format("expected one key in each step, got {}", map.entries().size()));
    if (map.has("scale")) return read_scale(map, lengths);
    if (map.has("rotate_deg")) return read_rotation(map, lengths);
    return read_translation(map, lengths);
}

Placement read_transform(const YamlMap& map, const LengthReader& lengths) {
    Placement transform;
    if (!map.has("transform")) return transform;
    for (const YamlNode& step : map.list("transform"))
        transform = compose(read_step(step, lengths), transform);
    const double det = std::abs(glm::determinant(transform.linear));
    // Not a comparison that NaN passes: the product of many steps may overflow.
    if (!(det >= 1e-18 && det <= 1e18 && is_finite(Vec3(transform.translation))))
        map.fail("transform", "expected a change of volume in [1e-18, 1e+18] altogether");
    return transform;
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
        objects[i].transform = {glm::mat3(placements[i].linear),
                                Vec3(placements[i].translation - origin)};
    return {std::move(objects), origin};
}

}  // namespace tallow
