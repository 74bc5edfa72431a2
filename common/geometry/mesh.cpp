// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/mesh.h"

namespace tallow {

namespace {

/// Twice the area of triangle t as a vector along its normal.
DVec3 area_vector(const TriangleMesh& mesh, std::size_t t) {
    const auto [a, b, c] = mesh.triangles[t];
    const DVec3 origin = mesh.vertices[a];
    return glm::cross(DVec3(mesh.vertices[b]) - origin, DVec3(mesh.vertices[c]) - origin);
}

}  // namespace

Vec3 triangle_normal(const TriangleMesh& mesh, std::size_t t) {
    return Vec3(glm::normalize(area_vector(mesh, t)));
}

double triangle_area(const TriangleMesh& mesh, std::size_t t) {
    return 0.5 * glm::length(area_vector(mesh, t));
}

}  // namespace tallow
