// SPDX-License-Identifier: Apache-2.0
#include "common/scene/mesh_emitter.h"

#include <xxhash.h>

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"

namespace tallow {
namespace {

std::vector<double> summed_areas(const TriangleMesh& mesh) {
    std::vector<double> sums;
    double area = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        sums.push_back(area += triangle_area(mesh, t));
    if (!(area > 0 && std::isfinite(float(area))))
        throw InputError("expected a mesh with an area that floats can hold");
    return sums;
}

std::vector<Surface> one_surface(TriangleMesh mesh) {
    std::vector<Surface> surfaces;
    surfaces.emplace_back(std::move(mesh));
    return surfaces;
}

}  // namespace

MeshEmitter::MeshEmitter(TriangleMesh mesh_of_light, std::string repair)
    : end_(summed_areas(mesh_of_light)),
      area_(float(end_.back())),
      surfaces_(one_surface(std::move(mesh_of_light))),
      rays_(surfaces_),
      repair_(std::move(repair)) {
    const double all = end_.back();
    for (double& end : end_) end /= all;
}

MeshEmitter::Point MeshEmitter::draw(Vec2 u) const {
    const auto found =
        std::min(std::upper_bound(end_.begin(), end_.end(), double(u.x)), end_.end() - 1);
    const double begin = found == end_.begin() ? 0 : found[-1];
    const double rest = std::clamp((u.x - begin) / (*found - begin), 0.0, 1.0);
    const std::size_t t = std::size_t(found - end_.begin());
    const auto& [a, b, c] = mesh().triangles[t];
    // (1 - s, s (1 - u.y), s u.y) with s = sqrt(rest) is uniform over the triangle.
    const float s = float(std::sqrt(rest));
    const auto& vertices = mesh().vertices;
    return {(1 - s) * vertices[a] + s * (1 - u.y) * vertices[b] + s * u.y * vertices[c],
            triangle_normal(mesh(), t)};
}

std::optional<MeshEmitter::Crossing> MeshEmitter::cross(const Ray& ray) const {
    const std::optional<Hit> hit = rays_.intersect(ray);
    if (!hit || glm::dot(hit->n_g, ray.direction) >= 0) return std::nullopt;
    return Crossing{hit->t, hit->n_g};
}

bool MeshEmitter::hides(const Point& point, Vec3 w, float distance) const {
    return rays_.occluded({rays_.offset_origin(point.position, point.normal, w), w, distance});
}

std::uint64_t MeshEmitter::hash() const {
    const auto bits = [](const auto& items) {
        return XXH3_64bits(items.data(), items.size() * sizeof(items[0]));
    };
    const std::uint64_t parts[2] = {bits(mesh().vertices), bits(mesh().triangles)};
    return XXH3_64bits(parts, sizeof parts);
}

}  // namespace tallow
