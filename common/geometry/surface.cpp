// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/base/overloaded.h"

namespace tallow {

Affine compose(const Affine& outer, const Affine& inner) {
    return {outer.linear * inner.linear, outer.linear * inner.translation + outer.translation};
}

namespace {

/// A corner of a face of the cube, as seen from outside with y, or for the faces across it -z and
/// z, pointing up.
Vec2 cube_uv(Vec3 corner, Vec3 n) {
    const Vec3 up = n.y == 0 ? Vec3(0, 1, 0) : Vec3(0, 0, -n.y);
    return Vec2(glm::dot(corner, glm::cross(up, n)), glm::dot(corner, up)) + 0.5f;
}

}  // namespace

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
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t])
            mesh.corner_uvs.push_back(cube_uv(mesh.vertices[v], triangle_normal(mesh, t)));
    return transform_mesh(std::move(mesh), to_world);
}

TriangleMesh transform_mesh(TriangleMesh mesh, const Affine& to_world) {
    for (Vec3& v : mesh.vertices) v = to_world.point(v);
    for (Vec3& n : mesh.corner_normals) n = to_world.normal(n);
    if (glm::determinant(to_world.linear) < 0) {
        for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
        for (std::size_t i = 0; i + 2 < mesh.corner_normals.size(); i += 3)
            std::swap(mesh.corner_normals[i + 1], mesh.corner_normals[i + 2]);
        for (std::size_t i = 0; i + 2 < mesh.corner_uvs.size(); i += 3)
            std::swap(mesh.corner_uvs[i + 1], mesh.corner_uvs[i + 2]);
    }
    return mesh;
}

Vec2 sphere_uv(DVec3 p) {
    using std::numbers::pi;
    return Vec2(0.5 + std::atan2(p.x, p.z) / (2 * pi),
                0.5 + std::asin(std::clamp(p.y, -1.0, 1.0)) / pi);
}

Vec2 disc_uv(DVec3 p) { return Vec2(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y); }

Vec2 plane_uv(const PlaneSurface& plane, DVec3 x) {
    const Frame frame = make_frame(plane.normal);
    const DVec3 way = x - DVec3(plane.point);
    return Vec2(glm::dot(way, DVec3(frame.s)), glm::dot(way, DVec3(frame.t)));
}

Box bounding_box(const Surface& surface) {
    Box box;
    // Around the image of a unit ball or disc: its half sizes are norms of rows.
    const auto add_image = [&](const Affine& to_world, int columns) {
        Vec3 half;
        for (int i = 0; i < 3; ++i) {
            float square = 0;
            for (int k = 0; k < columns; ++k)
                square += to_world.linear[k][i] * to_world.linear[k][i];
            half[i] = std::sqrt(square);
        }
        box.add(to_world.translation - half);
        box.add(to_world.translation + half);
    };
    std::visit(Overloaded{
                   [&](const TriangleMesh& mesh) {
                       for (const Vec3 v : mesh.vertices) box.add(v);
                   },
                   [&](const SphereSurface& sphere) { add_image(sphere.to_world, 3); },
                   [&](const DiscSurface& disc) { add_image(disc.to_world, 2); },
                   [&](const PlaneSurface& plane) {
                       box.add(plane.point - Vec3(plane.radius));
                       box.add(plane.point + Vec3(plane.radius));
                   },
               },
               surface);
    return box;
}

}  // namespace tallow
