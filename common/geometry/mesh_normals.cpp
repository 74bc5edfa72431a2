// SPDX-License-Identifier: Apache-2.0
//
// A repaired mesh and the soup it came from in, corner normals out. Repair renumbers vertices but
// never moves them, so a corner finds its normals in the file by its exact position.

#include "common/geometry/mesh_normals.h"

#include <algorithm>
#include <span>
#include <unordered_map>

#include "common/geometry/position_hash.h"

namespace tallow {

namespace {

std::vector<Vec3> triangle_normals(const TriangleMesh& mesh) {
    std::vector<Vec3> normals(mesh.triangles.size());
    for (std::size_t t = 0; t < normals.size(); ++t) normals[t] = triangle_normal(mesh, t);
    return normals;
}

/// Mean over the triangles around each vertex, weighted by their angle there: unlike a mean by
/// area it does not depend on how the surface is cut. Zero where the triangles cancel out.
/// Source: Thuermer, Wuethrich 1998, "Computing Vertex Normals from Polygonal Facets".
std::vector<Vec3> angle_weighted_normals(const TriangleMesh& mesh, std::span<const Vec3> n_g) {
    std::vector<DVec3> sum(mesh.vertices.size(), DVec3(0));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& corners = mesh.triangles[t];
        for (std::size_t c = 0; c < 3; ++c) {
            const DVec3 p = mesh.vertices[corners[c]];
            const DVec3 a = glm::normalize(DVec3(mesh.vertices[corners[(c + 1) % 3]]) - p);
            const DVec3 b = glm::normalize(DVec3(mesh.vertices[corners[(c + 2) % 3]]) - p);
            sum[corners[c]] += std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0)) * DVec3(n_g[t]);
        }
    }
    std::vector<Vec3> normals(sum.size(), Vec3(0));
    for (std::size_t v = 0; v < sum.size(); ++v)
        if (glm::length(sum[v]) > 1e-6) normals[v] = Vec3(glm::normalize(sum[v]));
    return normals;
}

/// The file's normals at each vertex of the mesh, unit; zero ones are left out.
class FileNormals {
public:
    FileNormals(const TriangleMesh& mesh, const PolygonSoup& soup)
        : at_vertex_(mesh.vertices.size()) {
        if (soup.normals.empty()) return;
        std::unordered_map<Vec3, std::vector<Vec3>, PositionHash> at_position;
        for (std::size_t i = 0; i < soup.normals.size(); ++i)
            if (const DVec3 n = soup.normals[i]; n != DVec3(0))
                at_position[soup.vertices[i]].push_back(Vec3(glm::normalize(n)));
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
            if (const auto found = at_position.find(mesh.vertices[v]); found != at_position.end())
                at_vertex_[v] = found->second;  // a copy: split vertices share a position
    }

    /// The one nearest to the direction n; zero if there is none.
    Vec3 nearest(std::uint32_t vertex, Vec3 n) const {
        Vec3 best(0);
        for (const Vec3 candidate : at_vertex_[vertex])
            if (best == Vec3(0) || glm::dot(candidate, n) > glm::dot(best, n)) best = candidate;
        return best;
    }

private:
    std::vector<std::vector<Vec3>> at_vertex_;
};

/// +1, or -1 for a turned component whose file normals face mostly away from its triangles.
std::vector<float> component_signs(const TriangleMesh& mesh, const TriangleOrigin& origin,
                                   const FileNormals& file, std::span<const Vec3> n_g) {
    std::vector<double> agreement(origin.turned.size(), 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) {
            // The nearest by line, not by direction: its sign is the question.
            const double along = glm::dot(file.nearest(v, n_g[t]), n_g[t]);
            const double against = glm::dot(file.nearest(v, -n_g[t]), n_g[t]);
            agreement[origin.component[t]] += along > -against ? along : against;
        }
    std::vector<float> signs(agreement.size(), 1);
    for (std::size_t k = 0; k < signs.size(); ++k)
        if (origin.turned[k] && agreement[k] < 0) signs[k] = -1;
    return signs;
}

}  // namespace

std::vector<Vec3> smooth_corner_normals(const TriangleMesh& mesh, const TriangleOrigin& origin,
                                        const PolygonSoup& soup) {
    const std::vector<Vec3> n_g = triangle_normals(mesh);
    const std::vector<Vec3> mean = angle_weighted_normals(mesh, n_g);
    const FileNormals file(mesh, soup);
    const std::vector<float> signs = component_signs(mesh, origin, file, n_g);

    std::vector<Vec3> normals;
    normals.reserve(3 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) {
            const float sign = signs[origin.component[t]];
            Vec3 n = sign * file.nearest(v, sign * n_g[t]);
            if (!(glm::dot(n, n_g[t]) > 0)) n = mean[v];
            if (!(glm::dot(n, n_g[t]) > 0)) n = n_g[t];
            normals.push_back(n);
        }
    return normals;
}

}  // namespace tallow
