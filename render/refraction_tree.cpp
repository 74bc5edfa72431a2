// SPDX-License-Identifier: Apache-2.0
// Triangles -> binary tree, split at the median of the longest axis of their centres.
#include "render/refraction_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tallow {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;  // chosen by time
constexpr float kPad = 1e-5f;                // rounding of positions and cosines, relative

struct Box {
    Vec3 low{kInfinity}, high{-kInfinity};
    void add(Vec3 p) { low = glm::min(low, p), high = glm::max(high, p); }
};

// Calls visit(normal) for the normals that bound those of triangle t.
template <class Visit>
void for_normals(const TriangleMesh& mesh, std::uint32_t t, Visit&& visit) {
    if (mesh.corner_normals.empty()) return visit(triangle_normal(mesh, t));
    for (std::size_t corner = 0; corner < 3; ++corner)
        visit(mesh.corner_normals[3 * std::size_t(t) + corner]);
}

}  // namespace

PatchBound bound_triangles(const TriangleMesh& mesh, const std::uint32_t* first,
                           const std::uint32_t* last) {
    Box box;
    Vec3 normals(0);
    for (const auto* t = first; t != last; ++t) {
        for (std::uint32_t v : mesh.triangles[*t]) box.add(mesh.vertices[v]);
        for_normals(mesh, *t, [&](Vec3 n) { normals += n; });
    }
    PatchBound bound{0.5f * (box.low + box.high), 0, Vec3(0, 0, 1), -1, 0};
    float r2 = 0, cosine = 1;
    const float length = glm::length(normals);
    if (length > 0) bound.axis = normals / length;
    for (const auto* t = first; t != last; ++t) {
        for (std::uint32_t v : mesh.triangles[*t])
            r2 = std::max(r2, length2(mesh.vertices[v] - bound.center));
        for_normals(mesh, *t, [&](Vec3 n) { cosine = std::min(cosine, glm::dot(n, bound.axis)); });
    }
    const Vec3 extent = glm::max(glm::abs(box.low), glm::abs(box.high));
    bound.radius = (1 + kPad) * std::sqrt(r2) + 1e-6f * std::max({extent.x, extent.y, extent.z});
    if (length > 0) bound.cos_cone = cosine - kPad;
    bound.sin_cone = std::sqrt(std::max(0.0f, 1 - bound.cos_cone * bound.cos_cone));
    return bound;
}

RefractionTree::RefractionTree(const TriangleMesh& mesh) : order_(mesh.triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    std::vector<Vec3> centers;
    centers.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles)
        centers.push_back((mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3.0f);
    if (!order_.empty()) build(mesh, centers, 0, std::uint32_t(order_.size()));
}

void RefractionTree::build(const TriangleMesh& mesh, const std::vector<Vec3>& centers,
                           std::uint32_t first, std::uint32_t last) {
    const std::size_t index = nodes_.size();
    const auto begin = order_.begin() + first, end = order_.begin() + last;
    nodes_.push_back({bound_triangles(mesh, &*begin, &*begin + (last - first)), first, 0, 0});
    if (last - first <= kLeafTriangles) {
        nodes_[index].count = last - first;
    } else {
        Box box;
        for (auto t = begin; t != end; ++t) box.add(centers[*t]);
        const Vec3 size = box.high - box.low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const std::uint32_t middle = first + (last - first) / 2;
        std::nth_element(begin, order_.begin() + middle, end, [&](auto a, auto b) {
            return std::pair(centers[a][axis], a) < std::pair(centers[b][axis], b);
        });
        build(mesh, centers, first, middle);
        build(mesh, centers, middle, last);
    }
    nodes_[index].skip = std::uint32_t(nodes_.size());
}

}  // namespace tallow
