// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <map>
#include <utility>

#include "common/geometry/mesh.h"

// Closed meshes around the origin, made in code.
namespace tallow::test {

/// An octahedron whose triangles are split in four `splits` times; `radius(q)` is the distance of
/// the vertex in unit direction q. Flat.
template <class Radius>
TriangleMesh ball_mesh(int splits, Radius&& radius) {
    TriangleMesh mesh;
    mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                      {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int split = 0; split < splits; ++split) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [entry, added] =
                middles.try_emplace(std::minmax(a, b), std::uint32_t(mesh.vertices.size()));
            if (added) mesh.vertices.push_back(glm::normalize(mesh.vertices[a] + mesh.vertices[b]));
            return entry->second;
        };
        std::vector<Triangle> finer;
        for (const auto& [a, b, c] : mesh.triangles) {
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            for (const Triangle& t : {Triangle{a, ab, ca}, Triangle{ab, b, bc}, Triangle{ca, bc, c},
                                      Triangle{ab, bc, ca}})
                finer.push_back(t);
        }
        mesh.triangles = std::move(finer);
    }
    for (Vec3& v : mesh.vertices) v *= float(radius(v));
    return mesh;
}

/// The mesh with the mean normal of its triangles, weighted by area, at each vertex.
inline TriangleMesh smoothed(TriangleMesh mesh) {
    std::vector<Vec3> normals(mesh.vertices.size(), Vec3(0));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::uint32_t v : mesh.triangles[t])
            normals[v] += float(triangle_area(mesh, t)) * triangle_normal(mesh, t);
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t) mesh.corner_normals.push_back(glm::normalize(normals[v]));
    return mesh;
}

/// A sphere with the normals of the sphere.
inline TriangleMesh sphere_mesh(int splits, float radius) {
    TriangleMesh mesh = ball_mesh(splits, [&](Vec3) { return radius; });
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t) mesh.corner_normals.push_back(glm::normalize(mesh.vertices[v]));
    return mesh;
}

/// A body with hollows and bumps of a tenth of its radius 10.
inline TriangleMesh bumpy_mesh(int splits) {
    return ball_mesh(splits, [](Vec3 q) {
        return 10 * (1 + 0.1f * std::sin(5 * q.x + 1) * std::cos(4 * q.y) * std::sin(6 * q.z + 2));
    });
}

}  // namespace tallow::test
