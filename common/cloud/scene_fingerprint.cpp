// SPDX-License-Identifier: Apache-2.0
// Scene -> readable pairs of all that the irradiance at the samples depends on. What is left out
// may change without a new pass one.
#include "common/cloud/scene_fingerprint.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>

#include "common/base/check.h"
#include "common/base/overloaded.h"

namespace tallow {
namespace {

/// Shortest text that reads back as the same number. Adding zero makes one of both zeros.
std::string text(float x) { return fmt::format("{}", x + 0.0f); }
std::string text(Vec3 v) { return fmt::format("{} {} {}", text(v.x), text(v.y), text(v.z)); }
std::string text(Rgb c) { return text(Vec3(c.r, c.g, c.b)); }

/// The rows of [linear | translation].
std::string text(const Affine& a) {
    std::string rows;
    for (int row = 0; row < 3; ++row)
        rows += fmt::format("{}{} {}", row == 0 ? "" : " ",
                            text(Vec3(a.linear[0][row], a.linear[1][row], a.linear[2][row])),
                            text(a.translation[row]));
    return rows;
}

std::string hash_text(std::uint64_t hash) { return fmt::format("xxh3:{:016x}", hash); }

const char* text(Normals normals) {
    switch (normals) {
        case Normals::automatic:
            return "auto";
        case Normals::flat:
            return "flat";
        case Normals::smooth:
            return "smooth";
    }
    TALLOW_CHECK(false, "normals {}", static_cast<int>(normals));
}

/// Appends the pairs of one object or light, under a common prefix.
class PairWriter {
public:
    PairWriter(Fingerprint& pairs, std::string prefix)
        : pairs_(pairs), prefix_(std::move(prefix)) {}

    void add(const char* key, std::string value) {
        pairs_.emplace_back(prefix_ + key, std::move(value));
    }
    void add(const char* key, float value) { add(key, text(value)); }
    void add(const char* key, Vec3 value) { add(key, text(value)); }
    void add(const char* key, Rgb value) { add(key, text(value)); }

private:
    Fingerprint& pairs_;
    std::string prefix_;
};

/// What differs from shape to shape. A mesh stands for the bytes of its file.
struct ShapePairs {
    PairWriter& pairs;
    std::uint64_t mesh_hash;
    float mm_per_unit;

    void operator()(const SphereShape& sphere) const {
        pairs.add("shape", "sphere");
        pairs.add("radius", sphere.radius);
    }
    void operator()(const CubeShape& cube) const {
        pairs.add("shape", "cube");
        pairs.add("size", cube.size);
    }
    void operator()(const DiscShape& disc) const {
        pairs.add("shape", "disc");
        pairs.add("normal", disc.normal);
        pairs.add("radius", disc.radius);
    }
    void operator()(const PlaneShape& plane) const {
        pairs.add("shape", "plane");
        pairs.add("normal", plane.normal);
        pairs.add("radius", plane.radius);
    }
    void operator()(const MeshShape& mesh) const {
        pairs.add("shape", "mesh");
        pairs.add("mesh", hash_text(mesh_hash));
        pairs.add("mm_per_unit", mm_per_unit);
        pairs.add("normals", text(mesh.normals));
    }
};

struct LightPairs {
    PairWriter& pairs;

    void operator()(const PointLight& light) const {
        pairs.add("type", "point");
        pairs.add("position", light.position);
        pairs.add("intensity", light.intensity);
    }
    void operator()(const DirectionalLight& light) const {
        pairs.add("type", "directional");
        pairs.add("direction", light.direction);
        pairs.add("irradiance", light.irradiance);
    }
    void operator()(const SpotLight& light) const {
        pairs.add("type", "spot");
        pairs.add("position", light.position);
        pairs.add("direction", light.direction);
        pairs.add("intensity", light.intensity);
        pairs.add("cos_inner", light.cos_inner);
        pairs.add("cos_outer", light.cos_outer);
    }
    void operator()(const QuadLight& light) const {
        pairs.add("type", "quad");
        pairs.add("center", light.center);
        pairs.add("u", light.u);
        pairs.add("v", light.v);
        pairs.add("normal", light.normal);
        pairs.add("radiance", light.radiance);
        if (light.texture) pairs.add("texture", hash_text(light.texture->hash()));
    }
    void operator()(const DiscLight& light) const {
        pairs.add("type", "disc");
        pairs.add("center", light.center);
        pairs.add("normal", light.normal);
        pairs.add("radius", light.radius);
        pairs.add("radiance", light.radiance);
    }
    void operator()(const SphereLight& light) const {
        pairs.add("type", "sphere");
        pairs.add("center", light.center);
        pairs.add("radius", light.radius);
        pairs.add("radiance", light.radiance);
    }
    void operator()(const MeshLight& light) const {
        pairs.add("type", "mesh");
        pairs.add("mesh", hash_text(light.mesh->hash()));
        pairs.add("radiance", light.radiance);
    }
    void operator()(const EnvironmentLight& light) const {
        pairs.add("type", "environment");
        pairs.add("radiance", light.radiance);
        if (!light.image) return;
        pairs.add("image", hash_text(light.image->hash()));
        pairs.add("rotation", light.rotation);
    }
};

/// The pixels count, not the file: they may come from another one.
std::string text(const RgbImage& image) {
    return fmt::format("{} x {} xxh3:{:016x}", image.width, image.height,
                       XXH3_64bits(image.pixels.data(), image.pixels.size() * sizeof(Rgb)));
}

void add_color(PairWriter& pairs, const std::string& key, const SurfaceColor& color) {
    const auto add = [&](const char* part, const auto& value) {
        pairs.add((key + part).c_str(), value);
    };
    add("", color.value);
    if (!color.texture) return;
    std::visit(Overloaded{
                   [&](const CheckerTexture& checker) {
                       add(".even", checker.even);
                       add(".odd", checker.odd);
                   },
                   [&](const ImageTexture& image) { add(".image", text(*image.image)); },
               },
               color.texture->kind);
    const bool in_uv = color.texture->coordinates == Texture::Coordinates::uv;
    add(".coordinates", std::string(in_uv ? "uv" : "object"));
    add(".period", color.texture->period);
}

/// Nothing for a body whose albedo is 1.
void add_albedo(PairWriter& pairs, const SurfaceColor& albedo) {
    if (albedo.texture || albedo.value != Rgb(1)) add_color(pairs, "albedo", albedo);
}

void add_object(Fingerprint& fingerprint, const Scene& scene, std::size_t index,
                std::uint64_t mesh_hash) {
    const Object& object = scene.objects[index];
    PairWriter pairs(fingerprint, fmt::format("objects[{}].", index));
    std::visit(ShapePairs{pairs, mesh_hash, scene.mm_per_unit}, object.shape);
    pairs.add("transform", text(object.transform));
    const SubsurfaceMaterial* material = subsurface(scene, index);
    pairs.add("translucent", material ? "yes" : "no");
    if (material) {
        pairs.add("eta", material->medium.eta);
        add_albedo(pairs, material->albedo);
    }
}

void add_light(Fingerprint& fingerprint, const Scene& scene, std::size_t index) {
    const Light& light = scene.lights[index];
    PairWriter pairs(fingerprint, fmt::format("lights[{}].", index));
    std::visit(LightPairs{pairs}, light.shape);
    pairs.add("group", scene.groups[light.group].name);
}

std::string_view name_of(Exit exit) {
    switch (exit) {
        case Exit::normalized:
            return "normalized";
        case Exit::classic:
            return "classic";
        case Exit::directional:
            return "directional";
    }
    return "";
}

/// What differs from material to material in how it reflects light.
struct MaterialPairs {
    PairWriter& pairs;

    void operator()(const SubsurfaceMaterial& body) const {
        pairs.add("sigma_a", body.medium.sigma_a);
        pairs.add("sigma_s_prime", body.medium.sigma_s_prime);
        pairs.add("g", body.medium.g);
        pairs.add("model", std::string(std::ranges::find(kModels, body.model,
                                                         &decltype(kModels)::value_type::second)
                                           ->first));
        pairs.add("exit", std::string(name_of(body.exit)));
        pairs.add("shifts", std::string(body.shifts ? "on" : "off"));
        pairs.add("boundary_elements", std::string(body.boundary_elements ? "on" : "off"));
        pairs.add("re_entry", std::string(body.re_entry ? "on" : "off"));
        pairs.add("transmission", std::string(body.transmission == Switch::off ? "off" : "on"));
    }
    void operator()(const DiffuseMaterial& diffuse) const {
        pairs.add("type", "diffuse");
        add_color(pairs, "reflectance", diffuse.reflectance);
    }
    void operator()(const PlasticMaterial& plastic) const {
        pairs.add("type", "plastic");
        add_color(pairs, "reflectance", plastic.reflectance);
        pairs.add("eta", plastic.eta);
    }
    void operator()(const MirrorMaterial& mirror) const {
        pairs.add("type", "mirror");
        pairs.add("reflectance", mirror.reflectance);
    }
};

void add_indirect_light(Fingerprint& fingerprint, const Scene& scene) {
    const int bounces = indirect_bounces(scene);
    fingerprint.emplace_back("indirect.bounces", fmt::format("{}", bounces));
    if (bounces == 0) return;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        PairWriter pairs(fingerprint, fmt::format("indirect.objects[{}].", i));
        std::visit(MaterialPairs{pairs}, scene.materials[scene.objects[i].material].kind);
    }
}

}  // namespace

Fingerprint scene_fingerprint(const Scene& scene, const SceneGeometry& geometry) {
    TALLOW_CHECK(geometry.mesh_hash.size() == scene.objects.size(), "{} hashes, {} objects",
                 geometry.mesh_hash.size(), scene.objects.size());
    // The counts come first: "objects = 2, but the scene has 3" says more than a missing pair.
    Fingerprint fingerprint{{"objects", fmt::format("{}", scene.objects.size())},
                            {"lights", fmt::format("{}", scene.lights.size())},
                            {"groups", fmt::format("{}", scene.groups.size())},
                            {"origin_mm", text(Vec3(scene.origin))}};
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        add_object(fingerprint, scene, i, geometry.mesh_hash[i]);
    for (std::size_t i = 0; i < scene.lights.size(); ++i) add_light(fingerprint, scene, i);
    for (std::size_t i = 0; i < scene.groups.size(); ++i)
        fingerprint.emplace_back(fmt::format("groups[{}].name", i), scene.groups[i].name);
    add_indirect_light(fingerprint, scene);
    if (indirect_bounces(scene) > 0)
        fingerprint.emplace_back("sampling.indirect_samples",
                                 scene.settings.indirect_samples
                                     ? fmt::format("{}", *scene.settings.indirect_samples)
                                     : "auto");
    fingerprint.emplace_back(
        "sampling.light_samples",
        scene.settings.light_samples ? fmt::format("{}", *scene.settings.light_samples) : "auto");
    return fingerprint;
}

}  // namespace tallow
