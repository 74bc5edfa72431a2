// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/surface.h"

#include <utility>

namespace tallow {

Affine compose(const Affine& outer, const Affine& inner) {
    return {outer.linear * inner.linear, outer.linear * inner.translation + outer.translation};
}

TriangleMesh cube_mesh(const Affine& to_world) {
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices.push_back(Vec3(i & 1, (i >> 1) & 1, (i >> 2) & 1) - Vec3(0.5f));
    // One quad a side, counter-clockwise from outside.
    constexpr std::uint32_t kQuads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                            {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const auto& q : kQuads) {
        mesh.triangles.push_back({q[0], q[1], q[2]});
        mesh.triangles.push_back({q[0], q[2], q[3]});
    }
    return transform_mesh(std::move(mesh), to_world);
}

TriangleMesh transform_mesh(TriangleMesh mesh, const Affine& to_world) {
    for (Vec3& v : mesh.vertices) v = to_world.point(v);
    for (Vec3& n : mesh.corner_normals) n = to_world.normal(n);
    if (glm::determinant(to_world.linear) < 0) {
        for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
        for (std::size_t i = 0; i + 2 < mesh.corner_normals.size(); i += 3)
            std::swap(mesh.corner_normals[i + 1], mesh.corner_normals[i + 2]);
    }
    return mesh;
}

}  // namespace tallow
