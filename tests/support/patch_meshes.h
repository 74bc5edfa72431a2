// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "common/geometry/mesh.h"

// Meshes that are hard to sample, made in code.
namespace tallow::test {

/// Appends `other` with vertices of its own.
inline void append(TriangleMesh& mesh, const TriangleMesh& other) {
    const auto offset = std::uint32_t(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const Triangle& t : other.triangles)
        mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
}

/// The parallelogram from `corner` along `u` and `v`, in n x n quads of two triangles each, with
/// the normal u x v.
inline TriangleMesh grid_mesh(Vec3 corner, Vec3 u, Vec3 v, std::uint32_t n) {
    TriangleMesh mesh;
    for (std::uint32_t j = 0; j <= n; ++j)
        for (std::uint32_t i = 0; i <= n; ++i)
            mesh.vertices.push_back(corner + (float(i) / float(n)) * u + (float(j) / float(n)) * v);
    for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t p = j * (n + 1) + i;
            mesh.triangles.push_back({p, p + 1, p + n + 2});
            mesh.triangles.push_back({p, p + n + 2, p + n + 1});
        }
    return mesh;
}

/// A closed cylinder around the z axis whose side is 2 n needles as long as itself, and whose caps
/// are fans of n wedges.
inline TriangleMesh needle_mesh(std::uint32_t n, float radius, float length) {
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < n; ++i) {
        const double phi = 2 * std::numbers::pi * i / n;
        const Vec3 p(radius * float(std::cos(phi)), radius * float(std::sin(phi)), 0);
        mesh.vertices.push_back(p);
        mesh.vertices.push_back(p + Vec3(0, 0, length));
    }
    mesh.vertices.push_back({0, 0, 0});
    mesh.vertices.push_back({0, 0, length});
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % n);
        mesh.triangles.push_back({a, b, b + 1});
        mesh.triangles.push_back({a, b + 1, a + 1});
        mesh.triangles.push_back({2 * n, b, a});
        mesh.triangles.push_back({2 * n + 1, a + 1, b + 1});
    }
    return mesh;
}

}  // namespace tallow::test
