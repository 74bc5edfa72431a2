// SPDX-License-Identifier: Apache-2.0
// Polygon soups to repair, and what a repaired mesh must be.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "common/geometry/mesh_repair.h"

namespace tallow {

using Polygons = std::vector<std::vector<std::uint32_t>>;

/// The axis-parallel box as six quads that face outward.
inline PolygonSoup box(Vec3 low, Vec3 high) {
    PolygonSoup soup;
    for (int i = 0; i < 8; ++i)
        soup.vertices.push_back(
            {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
    soup.polygons = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                     {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    return soup;
}

inline PolygonSoup unit_cube() { return box({0, 0, 0}, {1, 1, 1}); }

/// Octahedron around the origin, its faces cut in four and moved onto the sphere `times` times.
inline PolygonSoup sphere(float radius, int times) {
    PolygonSoup soup{
        {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
        {},
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
    for (int i = 0; i < times; ++i) {
        Polygons finer;
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
        const auto halve = [&](std::uint32_t a, std::uint32_t b) {
            const auto next = static_cast<std::uint32_t>(soup.vertices.size());
            const auto [m, is_new] = middle.try_emplace(std::minmax(a, b), next);
            if (is_new)
                soup.vertices.push_back(glm::normalize(soup.vertices[a] + soup.vertices[b]));
            return m->second;
        };
        for (const auto& p : soup.polygons) {
            const auto ab = halve(p[0], p[1]), bc = halve(p[1], p[2]), ca = halve(p[2], p[0]);
            finer.insert(finer.end(),
                         {{p[0], ab, ca}, {ab, p[1], bc}, {ca, bc, p[2]}, {ab, bc, ca}});
        }
        soup.polygons = finer;
    }
    for (Vec3& v : soup.vertices) v *= radius;
    return soup;
}

inline PolygonSoup join(PolygonSoup a, const PolygonSoup& b) {
    const auto offset = static_cast<std::uint32_t>(a.vertices.size());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    a.normals.insert(a.normals.end(), b.normals.begin(), b.normals.end());
    for (auto polygon : b.polygons) {
        for (auto& v : polygon) v += offset;
        a.polygons.push_back(polygon);
    }
    return a;
}

inline PolygonSoup inside_out(PolygonSoup soup) {
    for (auto& polygon : soup.polygons) std::reverse(polygon.begin(), polygon.end());
    return soup;
}

/// Every polygon with vertices of its own, as in an STL file read word by word.
inline PolygonSoup exploded(const PolygonSoup& soup) {
    PolygonSoup result;
    for (const auto& polygon : soup.polygons) {
        result.polygons.emplace_back();
        for (const auto v : polygon) {
            result.polygons.back().push_back(static_cast<std::uint32_t>(result.vertices.size()));
            result.vertices.push_back(soup.vertices[v]);
        }
    }
    return result;
}

inline RepairedMesh repair(const PolygonSoup& soup, Normals normals = Normals::automatic) {
    return repair_mesh(soup, normals, "test.ply");
}

inline double volume(const TriangleMesh& mesh) {
    double sum = 0;
    for (const auto [a, b, c] : mesh.triangles)
        sum += glm::dot(DVec3(mesh.vertices[a]),
                        glm::cross(DVec3(mesh.vertices[b]), DVec3(mesh.vertices[c]))) /
               6;
    return sum;
}

using DirectedEdges = std::map<std::pair<std::uint32_t, std::uint32_t>, int>;

inline DirectedEdges directed_edges(const std::vector<Triangle>& triangles) {
    DirectedEdges uses;
    for (const Triangle& t : triangles)
        for (std::size_t c = 0; c < 3; ++c) ++uses[{t[c], t[(c + 1) % 3]}];
    return uses;
}

inline bool is_closed(const TriangleMesh& mesh) {
    const DirectedEdges uses = directed_edges(mesh.triangles);
    return std::all_of(uses.begin(), uses.end(), [&](const auto& e) {
        return uses.contains({e.first.second, e.first.first});
    });
}

/// Whether the triangles around a vertex hang together by edges at it: they are one fan.
inline bool is_one_fan(std::uint32_t vertex, std::vector<Triangle> around) {
    std::set<std::uint32_t> reached{around[0][0], around[0][1], around[0][2]};
    for (std::size_t left = around.size() + 1; left > around.size();) {
        left = around.size();
        std::erase_if(around, [&](const Triangle& t) {
            const auto near = [&](std::uint32_t v) { return v != vertex && reached.contains(v); };
            if (std::none_of(t.begin(), t.end(), near)) return false;
            reached.insert(t.begin(), t.end());
            return true;
        });
    }
    return around.empty();
}

/// The slow twin of is_oriented_manifold.
inline bool is_manifold(const std::vector<Triangle>& triangles) {
    for (const auto& [edge, uses] : directed_edges(triangles))
        if (uses != 1) return false;
    std::map<std::uint32_t, std::vector<Triangle>> around;
    std::set<std::set<std::uint32_t>> corners;
    for (const Triangle& t : triangles) {
        for (const std::uint32_t v : t) around[v].push_back(t);
        if (!corners.insert({t.begin(), t.end()}).second) return false;
    }
    return std::all_of(around.begin(), around.end(),
                       [](const auto& v) { return is_one_fan(v.first, v.second); });
}

inline void expect_body(const RepairedMesh& result, double expected_volume,
                        std::size_t components = 1) {
    EXPECT_TRUE(is_closed(result.mesh));
    EXPECT_TRUE(is_manifold(result.mesh.triangles));
    EXPECT_NEAR(volume(result.mesh), expected_volume, 1e-9 + 1e-6 * expected_volume);
    EXPECT_EQ(result.report.boundary_loops, 0u) << result.report.boundary;
    EXPECT_EQ(result.report.components, components);
    for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
        EXPECT_GT(triangle_area(result.mesh, t), 0);
}

}  // namespace tallow
