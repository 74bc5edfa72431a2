// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/base/rgb.h"
#include "common/geometry/mesh_repair.h"
#include "common/geometry/ray_scene.h"
#include "common/geometry/surface.h"
#include "common/optics/medium.h"
#include "common/optics/profile.h"
#include "common/scene/camera.h"
#include "common/scene/light.h"
#include "common/scene/texture.h"

namespace tallow {

/// How light leaves a translucent surface: T(w_o) of L = M / pi * T.
enum class Exit {
    normalized,  ///< F_t / (2 * integral of F_t mu): energy is kept
    classic,     ///< F_t, as printed in the papers: loses about 10 % at eta 1.5
    directional  ///< F_t (1 + a mu'), of light that diffusion brings to the surface; keeps energy
};

/// A term may be computed always, never, or where it can matter.
enum class Switch { automatic, on, off };

/// How light is followed through a body's surface to where it scatters once.
enum class Connection {
    straight,  ///< along a straight line, its length inside corrected: the papers' way
    exact      ///< along every path that obeys Snell's law, and over reflections inside
};

struct SubsurfaceMaterial {
    Medium medium;
    Model model = Model::transport;
    Exit exit = Exit::normalized;
    Switch single_scattering = Switch::automatic;
    Connection connection = Connection::exact;
    /// Whether light is followed that passes the body without being scattered.
    Switch transmission = Switch::automatic;
    /// Whether the medium is taken for a diffuse surface, which it is where its mean free paths are
    /// far below a pixel.
    Switch diffuse_limit = Switch::automatic;
    /// Light enters and leaves sideways: both ends of the profile are moved along the surface.
    bool shifts = false;
    /// The profile's half-space is corrected to the body by a solve of diffusion in it.
    bool boundary_elements = false;
    /// Light that left the body by diffusion enters it again where it meets it: part of indirect
    /// light.
    bool re_entry = true;
    /// Tints light on its way in and on its way out with its square root each, so that a constant
    /// one scales the total reflectance.
    SurfaceColor albedo{Rgb(1)};
};

/// Sets the model, and what goes with it unless a scene says otherwise: exit, shifts and boundary
/// elements.
void use_model(SubsurfaceMaterial& material, Model model);

/// Lambertian reflection.
struct DiffuseMaterial {
    SurfaceColor reflectance;
};

/// Lambertian base under a smooth dielectric coat.
struct PlasticMaterial {
    SurfaceColor reflectance;  ///< of the base alone, as if uncoated
    float eta;
};

struct MirrorMaterial {
    Rgb reflectance;
};

struct Material {
    std::string name;
    std::variant<SubsurfaceMaterial, DiffuseMaterial, PlasticMaterial, MirrorMaterial> kind;
};

/// Shapes around the origin of their own space, in mm; Object::transform puts them into the world.
struct SphereShape {
    float radius;
};
struct CubeShape {
    Vec3 size;
};
struct DiscShape {
    Vec3 normal;
    float radius;
};
struct PlaneShape {
    Vec3 normal;
    float radius;  // PlaneSurface::radius
};
struct MeshShape {
    std::filesystem::path file;
    Normals normals;
};
using Shape = std::variant<SphereShape, CubeShape, DiscShape, PlaneShape, MeshShape>;

/// Whether the shape has an inside; planes stand for half-spaces.
inline bool encloses_volume(const Shape& shape) {
    return !std::holds_alternative<PlaneShape>(shape) && !std::holds_alternative<DiscShape>(shape);
}

struct Object {
    Shape shape;
    std::uint32_t material;  // index into Scene::materials
    Affine transform;        // object space -> world; the file's center or point is part of it
    std::string where;       // "scene.yaml:12:5", to report what is wrong with it later
};

struct LightGroup {
    std::string name;
    Rgb scale{1};  // multiplies all its lights; not baked into a cache
};

struct Settings {
    float tolerance = 0.01f;  // relRMSE the user accepts
    int samples = 16;         // camera rays a pixel
    /// Shadow rays a light and sample in pass one; without it as many as the tolerance needs.
    std::optional<int> light_samples;
    /// Times that light may be reflected, by whatever surface, before it reaches a sample; without
    /// a number as indirect_bounces() says.
    std::optional<int> bounces;
    /// Paths of indirect light from each sample; without a number, from patches, by the tolerance.
    std::optional<int> indirect_samples;
    /// Depths a pixel at which light scattered once is collected; without a number, from the
    /// tolerance.
    std::optional<int> single_scattering_depths;
    bool everything = false;  // compute also what the plan would leave out
};

/// Everything a scene file says, validated: indices in range, numbers finite and in their domain,
/// lengths in mm, angles in radians. At least one camera. What lights and textures need of files is
/// read; meshes of objects are named, not yet read.
struct Scene {
    std::filesystem::path file;
    /// Where the world's origin lies in the file's coordinates, mm. Everything else is relative to
    /// it, so that a scene far from its file's origin keeps the precision of float. Zero for scenes
    /// within half a metre of it; see scene_origin.
    DVec3 origin{0};
    std::vector<Camera> cameras;  // the first is the default
    std::vector<Material> materials;
    std::vector<Object> objects;
    std::vector<Light> lights;
    std::vector<LightGroup> groups;
    Settings settings;
    float mm_per_unit = 1;  // of the scene's `unit`, applied to mesh files as well
};

/// Times that light may be reflected before it reaches a sample or an opaque surface: the setting,
/// or else 2 if anything can reflect light onto something, 0 if the scene is one convex object.
int indirect_bounces(const Scene& scene);

/// Where a hit lies in the textures of its object.
TexturePoint texture_point(const Scene& scene, const Hit& hit);

/// The texture of a material, or null.
const Texture* texture_of(const Material& material);

/// What the texture says where a surface is hit; 1 for one without.
Rgb texture_value(const Scene& scene, const Hit& hit);

/// What light through a body's surface is multiplied with, on its way in and again on its way out:
/// the square root of the body's albedo there.
Rgb surface_tint(const Scene& scene, const SurfaceColor& albedo, const Hit& hit);

/// The subsurface material of an object, or null for an opaque one.
inline const SubsurfaceMaterial* subsurface(const Scene& scene, std::size_t object) {
    return std::get_if<SubsurfaceMaterial>(&scene.materials[scene.objects[object].material].kind);
}

}  // namespace tallow
