// SPDX-License-Identifier: Apache-2.0
// Objects of a scene -> bodies, and what of a scene the reference refuses.
#include "experiments/reference/bodies.h"

#include <fmt/format.h>

#include <cmath>

#include "common/base/errors.h"

namespace tallow::reference {
namespace {

[[noreturn]] void refuse(const Scene& scene, std::uint32_t object, const std::string& what) {
    throw InputError(fmt::format("{}: objects[{}]: {}", scene.objects[object].where, object, what));
}

const SubsurfaceMaterial& require_plain_body(const Scene& scene, std::uint32_t object) {
    const SubsurfaceMaterial* material = subsurface(scene, object);
    if (material == nullptr)
        refuse(scene, object,
               fmt::format("expected a subsurface material, got the opaque '{}': the reference "
                           "knows translucent bodies only",
                           scene.materials[scene.objects[object].material].name));
    if (material->albedo.texture || !(material->albedo.value == Rgb(1)))
        refuse(scene, object, "expected a material without albedo, got a tinted surface");
    if (!(material->medium.eta >= 1))
        refuse(scene, object,
               fmt::format("expected eta >= 1, got {}", double(material->medium.eta)));
    return *material;
}

/// Radius of a sphere that is one; 0 for an ellipsoid.
float round_radius(const SphereSurface& sphere) {
    const glm::mat3& m = sphere.to_world.linear;
    const glm::mat3 square = glm::transpose(m) * m;
    const float r2 = (square[0][0] + square[1][1] + square[2][2]) / 3;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (std::abs(square[i][j] - (i == j ? r2 : 0)) > 1e-5f * r2) return 0;
    return std::sqrt(r2);
}

float diagonal(const Surface& surface) {
    const Box box = bounding_box(surface);
    return glm::length(box.high - box.low);
}

}  // namespace

Bodies::Bodies(const Scene& scene, const SceneGeometry& geometry, const Camera& camera,
               const Detail& detail)
    : camera_(camera.position) {
    Box box;
    bodies_.reserve(scene.objects.size());
    for (std::uint32_t object = 0; object < scene.objects.size(); ++object) {
        add(scene, geometry, object, detail);
        const Box of_object = bounding_box(geometry.surfaces[object]);
        box.add(of_object.low), box.add(of_object.high);
    }
    if (bodies_.empty())
        throw InputError(
            fmt::format("{}: objects: expected a translucent body, got none", scene.file.string()));
    center_ = (box.low + box.high) / 2.0f;
    radius_ = glm::length(box.high - box.low) / 2;
    require_camera_outside(scene);
}

void Bodies::add(const Scene& scene, const SceneGeometry& geometry, std::uint32_t object,
                 const Detail& detail) {
    const Medium& medium = require_plain_body(scene, object).medium;
    const Surface& surface = geometry.surfaces[object];
    std::array<float, 3> reaches{};
    float longest = 0;
    for (int c = 0; c < 3; ++c) {
        reaches[std::size_t(c)] = std::min(detail.reach / medium.sigma_t()[c], diagonal(surface));
        longest = std::max(longest, reaches[std::size_t(c)]);
    }
    const double eta = double(medium.eta);
    if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) {
        if (!mesh->corner_normals.empty())
            refuse(scene, object, "normals: expected flat, got smooth ones");
        bodies_.push_back({MeshBody(*mesh, eta, camera_, double(longest), detail.cells), medium,
                           reaches, object});
        return;
    }
    const auto* sphere = std::get_if<SphereSurface>(&surface);
    if (sphere == nullptr) refuse(scene, object, "shape: expected sphere, cube or mesh");
    const float radius = round_radius(*sphere);
    if (radius == 0) refuse(scene, object, "transform: expected a round sphere, got an ellipsoid");
    bodies_.push_back(
        {SphereBody(sphere->to_world.translation, radius, eta, camera_), medium, reaches, object});
}

void Bodies::require_camera_outside(const Scene& scene) const {
    for (const Body& body : bodies_)
        if (std::visit([&](const auto& shape) { return shape.holds(Vec3(camera_)); }, body.shape))
            refuse(scene, body.object, "expected the camera outside, got it inside");
}

std::optional<Bodies::Entry> Bodies::enter(Vec3 origin, Vec3 direction) const {
    std::optional<Entry> nearest;
    for (std::uint32_t i = 0; i < bodies_.size(); ++i) {
        const float length = nearest ? nearest->crossing.t : kInfinity;
        const std::optional<Crossing> hit =
            std::visit([&](const auto& shape) { return shape.enter(origin, direction, length); },
                       bodies_[i].shape);
        if (hit) nearest = Entry{i, *hit};
    }
    return nearest;
}

bool Bodies::is_clear(std::uint32_t body, Vec3 x, const CameraLink& link) const {
    if (!std::visit([&](const auto& shape) { return shape.is_clear(x, link); },
                    bodies_[body].shape))
        return false;
    const Vec3 from(camera_), way((link.position - camera_) / link.outside);
    for (std::uint32_t i = 0; i < bodies_.size(); ++i)
        if (i != body && std::visit(
                             [&](const auto& shape) {
                                 return shape.enter(from, way, float(link.outside)).has_value();
                             },
                             bodies_[i].shape))
            return false;
    return true;
}

}  // namespace tallow::reference
