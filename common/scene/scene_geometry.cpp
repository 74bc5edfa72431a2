// SPDX-License-Identifier: Apache-2.0
// Shapes of the scene file -> surfaces in world space. Meshes are read, repaired and, where they
// are translucent, required to enclose a volume.
#include "common/scene/scene_geometry.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <fstream>

#include "common/base/errors.h"
#include "common/base/overloaded.h"

namespace tallow {
namespace {

std::uint64_t hash_file(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    XXH3_state_t* state = XXH3_createState();
    XXH3_64bits_reset(state);
    std::vector<char> block(1 << 20);
    while (stream.read(block.data(), std::streamsize(block.size())), stream.gcount() > 0)
        XXH3_64bits_update(state, block.data(), std::size_t(stream.gcount()));
    const std::uint64_t hash = XXH3_64bits_digest(state);
    XXH3_freeState(state);
    return hash;
}

void require_closed(const Object& object, const std::string& file, const RepairReport& report) {
    if (report.boundary_loops == 0) return;
    throw InputError(
        fmt::format("{}: {}: a translucent body must enclose a volume, but this mesh "
                    "is open: {}; close it, or give it an opaque material",
                    object.where, file, report.boundary));
}

void require_uvs(const Scene& scene, const Object& object, const std::string& file,
                 const PolygonSoup& soup) {
    const Material& material = scene.materials[object.material];
    const Texture* texture = texture_of(material);
    if (texture == nullptr || texture->coordinates != Texture::Coordinates::uv) return;
    if (!soup.uvs.empty() && soup.corners_without_uv == 0) return;
    const std::string corners = soup.uvs.empty()
                                    ? "this mesh has"
                                    : fmt::format("{} of this mesh's {} corners have",
                                                  soup.corners_without_uv, soup.uvs.size());
    throw InputError(
        fmt::format("{}: {}: {} no texture coordinates, which the texture of material '{}' "
                    "needs; give the texture 'coordinates: object'",
                    object.where, file, corners, material.name));
}

class SurfaceLoader {
public:
    SurfaceLoader(const Scene& scene, SceneGeometry& geometry, Stats& stats)
        : scene_(scene), geometry_(geometry), stats_(stats) {}

    void load(std::size_t index) {
        const Object& object = scene_.objects[index];
        geometry_.mesh_hash.push_back(0);
        geometry_.surfaces.push_back(
            std::visit(Overloaded{
                           [&](const SphereShape& s) -> Surface {
                               const Affine unit{glm::mat3(s.radius), Vec3(0)};
                               return SphereSurface{compose(object.transform, unit)};
                           },
                           [&](const CubeShape& s) -> Surface {
                               glm::mat3 size(0.0f);
                               for (int i = 0; i < 3; ++i) size[i][i] = s.size[i];
                               return cube_mesh(compose(object.transform, {size, Vec3(0)}));
                           },
                           [&](const DiscShape& s) -> Surface { return disc(object.transform, s); },
                           [&](const PlaneShape& s) -> Surface {
                               return PlaneSurface{object.transform.translation,
                                                   object.transform.normal(s.normal), s.radius};
                           },
                           [&](const MeshShape& s) -> Surface { return mesh(index, s); },
                       },
                       object.shape));
    }

private:
    static Surface disc(const Affine& transform, const DiscShape& s) {
        const Frame frame = make_frame(s.normal);
        const glm::mat3 axes(s.radius * frame.s, s.radius * frame.t, s.radius * frame.n);
        return DiscSurface{compose(transform, {axes, Vec3(0)})};
    }

    Surface mesh(std::size_t index, const MeshShape& shape) {
        const Object& object = scene_.objects[index];
        const std::string name = shape.file.string();
        PhaseTimer load_timer(stats_, "load");
        PolygonSoup soup = read_polygon_soup(shape.file);
        geometry_.mesh_hash.back() = hash_file(shape.file);
        load_timer.stop();
        require_uvs(scene_, object, name, soup);
        const PhaseTimer repair_timer(stats_, "repair");
        RepairedMesh repaired = repair_mesh(std::move(soup), shape.normals, name);
        if (subsurface(scene_, index) != nullptr) require_closed(object, name, repaired.report);
        if (repaired.report.changed_anything())
            geometry_.repair_reports.push_back(name + ": " + repaired.report.summary());
        const Affine to_mm{glm::mat3(scene_.mm_per_unit), Vec3(0)};
        return transform_mesh(std::move(repaired.mesh), compose(object.transform, to_mm));
    }

    const Scene& scene_;
    SceneGeometry& geometry_;
    Stats& stats_;
};

}  // namespace

SceneGeometry load_geometry(const Scene& scene, Stats& stats) {
    SceneGeometry geometry;
    SurfaceLoader loader(scene, geometry, stats);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) loader.load(i);
    for (const Light& light : scene.lights)
        if (const auto* mesh = std::get_if<MeshLight>(&light.shape);
            mesh && !mesh->mesh->repair().empty())
            geometry.repair_reports.push_back(mesh->mesh->repair());
    return geometry;
}

}  // namespace tallow
