// SPDX-License-Identifier: Apache-2.0
// Triangle -> its plane and barycentric coordinates, in float.
#include "render/beam_gate.h"

namespace tallow {

BeamQuery beam_query(const Ends& ends, float reach) {
    constexpr double kOfAngle = 1.15;  // largest angle / sine, for angles below 48 degrees
    const DVec3 to_y = ends.y_at_infinity ? ends.y : ends.y - ends.x;
    const double distance = glm::length(to_y);
    const double cos2 = 1 - 1 / (ends.eta * ends.eta);
    const double turn = ends.y_at_infinity ? 0 : kOfAngle / (ends.eta * cos2 * cos2 * distance);
    return {Vec3(ends.x), Vec3(to_y / distance), float(1 / ends.eta), reach,
            float(std::min(turn, 1e30))};
}

BeamGate::BeamGate(const TriangleMesh& mesh, std::size_t triangle) {
    const auto& [a, b, c] = mesh.triangles[triangle];
    const DVec3 corner(mesh.vertices[a]);
    const DVec3 e1 = DVec3(mesh.vertices[b]) - corner, e2 = DVec3(mesh.vertices[c]) - corner;
    const DVec3 across = glm::cross(e1, e2);
    const double area2 = glm::dot(across, across);
    corner_ = Vec3(corner), normal_ = Vec3(glm::normalize(across));
    const DVec3 u_of = glm::cross(e2, across) / area2, v_of = glm::cross(across, e1) / area2;
    u_of_ = Vec3(u_of), v_of_ = Vec3(v_of);
    steep_ = float(std::max({glm::length(u_of), glm::length(v_of), glm::length(u_of + v_of)}));
    constexpr double kOfPosition = 1e-6;  // eight units in the last place of float
    rounding_ = float(kOfPosition * (glm::length(corner) + glm::length(e1) + glm::length(e2)));
}

}  // namespace tallow
