// SPDX-License-Identifier: Apache-2.0
//
// A repaired mesh and the soup it came from in, corner uvs out. Repair renumbers vertices but never
// moves them, and remembers of which polygon each triangle is a part: a corner finds its uv among
// that polygon's by its exact position.

#include "common/geometry/mesh_uvs.h"

#include <algorithm>
#include <limits>

namespace tallow {

namespace {

/// A polygon of the file and the uvs of its corners.
struct UvPolygon {
    const PolygonSoup& file;
    std::span<const std::uint32_t> corners;
    const Vec2* uvs;

    Vec3 position(std::size_t corner) const { return file.vertices[corners[corner]]; }

    Vec2 at(Vec3 p) const {
        for (std::size_t c = 0; c < corners.size(); ++c)
            if (position(c) == p) return uvs[c];
        return on_border(p);
    }

    /// At the point of the border that is nearest to p.
    Vec2 on_border(DVec3 p) const {
        double least = std::numeric_limits<double>::infinity();
        Vec2 uv(0);
        for (std::size_t c = 0; c < corners.size(); ++c) {
            const std::size_t next = (c + 1) % corners.size();
            const DVec3 a = position(c), ab = DVec3(position(next)) - a;
            const double length2 = glm::dot(ab, ab);
            const double s =
                length2 > 0 ? std::clamp(glm::dot(p - a, ab) / length2, 0.0, 1.0) : 0.0;
            const DVec3 way = p - (a + s * ab);
            if (!(glm::dot(way, way) < least)) continue;
            least = glm::dot(way, way);
            uv = glm::mix(uvs[c], uvs[next], static_cast<float>(s));
        }
        return uv;
    }
};

}  // namespace

std::vector<Vec2> find_corner_uvs(const TriangleMesh& mesh, std::span<const std::uint32_t> polygon,
                                  const PolygonSoup& file) {
    std::vector<std::size_t> first(1, 0);  // [polygon] of its uvs
    for (const auto& corners : file.polygons) first.push_back(first.back() + corners.size());
    std::vector<Vec2> uvs;
    uvs.reserve(3 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const UvPolygon source{file, file.polygons[polygon[t]], &file.uvs[first[polygon[t]]]};
        for (const std::uint32_t v : mesh.triangles[t]) uvs.push_back(source.at(mesh.vertices[v]));
    }
    return uvs;
}

}  // namespace tallow
