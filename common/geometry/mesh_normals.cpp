// SPDX-License-Identifier: Apache-2.0
//
// A repaired mesh and the soup it came from in, corner normals out. Repair renumbers vertices but
// never moves them, so a corner finds its normals in the file by its exact position.

#include "common/geometry/mesh_normals.h"

#include <limits>
#include <span>
#include <utility>

#include "common/geometry/position_table.h"

namespace tallow {

namespace {

std::vector<Vec3> triangle_normals(const TriangleMesh& mesh) {
    std::vector<Vec3> normals(mesh.triangles.size());
    for (std::size_t t = 0; t < normals.size(); ++t) normals[t] = triangle_normal(mesh, t);
    return normals;
}

/// The file's normals at each vertex of the mesh, unit; zero ones are left out.
class FileNormals {
public:
    FileNormals(const TriangleMesh& mesh, const PolygonSoup& soup)
        : first_(mesh.vertices.size(), kNone), next_(soup.normals.size(), kNone) {
        if (soup.normals.empty()) return;
        PositionTable at_position(soup.vertices, soup.normals.size());
        normals_.reserve(soup.normals.size());
        for (std::uint32_t i = 0; i < soup.normals.size(); ++i) {
            const DVec3 n = soup.normals[i];
            normals_.push_back(n == DVec3(0) ? Vec3(0) : Vec3(glm::normalize(n)));
            if (n == DVec3(0)) continue;
            const std::uint32_t first = at_position.find_or_enter(soup.vertices[i], i);
            if (first != i) next_[i] = std::exchange(next_[first], i);
        }
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
            first_[v] = at_position.find(mesh.vertices[v]);
    }

    /// The one nearest to the direction n; zero if there is none.
    Vec3 nearest(std::uint32_t vertex, Vec3 n) const {
        Vec3 best(0);
        for (std::uint32_t i = first_[vertex]; i != kNone; i = next_[i])
            if (best == Vec3(0) || glm::dot(normals_[i], n) > glm::dot(best, n)) best = normals_[i];
        return best;
    }

private:
    static constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();

    std::vector<std::uint32_t> first_;  // [vertex of the mesh] a vertex of the file at its position
    std::vector<std::uint32_t> next_;   // [vertex of the file] another at the same position
    std::vector<Vec3> normals_;         // [vertex of the file]
};

std::vector<Vec3> mean_normals(const TriangleMesh& mesh) {
    std::vector<DVec3> sum(mesh.vertices.size(), DVec3(0));
    for (const Triangle& t : mesh.triangles)
        for (std::size_t c = 0; c < 3; ++c) {
            const DVec3 p = mesh.vertices[t[c]];
            const DVec3 a = DVec3(mesh.vertices[t[(c + 1) % 3]]) - p;
            const DVec3 b = DVec3(mesh.vertices[t[(c + 2) % 3]]) - p;
            const DVec3 cross = glm::cross(a, b);
            const double sine = glm::length(cross);
            sum[t[c]] += std::atan2(sine, glm::dot(a, b)) / sine * cross;
        }
    std::vector<Vec3> normals(sum.size(), Vec3(0));
    for (std::size_t v = 0; v < sum.size(); ++v)
        if (glm::length(sum[v]) > 1e-6) normals[v] = Vec3(glm::normalize(sum[v]));
    return normals;
}

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
    const FileNormals file(mesh, soup);
    const std::vector<float> signs = component_signs(mesh, origin, file, n_g);

    std::vector<Vec3> mean;  // made when first needed: most files with normals need none
    const auto mean_normal = [&](std::uint32_t v) {
        if (mean.empty()) mean = mean_normals(mesh);
        return mean[v];
    };
    std::vector<Vec3> normals;
    normals.reserve(3 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) {
            const float sign = signs[origin.component[t]];
            Vec3 n = sign * file.nearest(v, sign * n_g[t]);
            if (!(glm::dot(n, n_g[t]) > 0)) n = mean_normal(v);
            if (!(glm::dot(n, n_g[t]) > 0)) n = n_g[t];
            normals.push_back(n);
        }
    return normals;
}

}  // namespace tallow
