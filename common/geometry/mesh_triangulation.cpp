// SPDX-License-Identifier: Apache-2.0
//
// A polygon in space in, triangles out, by clipping ears, the best shaped first. CGAL's
// triangulation of faces is not used: with constraints it hangs on polygons that cross themselves,
// without, its time grows with the third power of the corners.
// Source: Meisters 1975, "Polygons have ears"; Newell's normal after Sutherland et al. 1974,
// "A Characterization of Ten Hidden-Surface Algorithms".

#include <algorithm>

#include "common/geometry/mesh_repair_steps.h"

namespace tallow {

namespace {

using DVec2 = glm::dvec2;

/// The polygon in the coordinate plane that it covers most of, turning counter-clockwise there.
/// Leaving a coordinate out rounds nothing: what lies on a line stays on it.
std::vector<DVec2> flatten(std::span<const Vec3> vertices, std::span<const std::uint32_t> polygon) {
    const DVec3 origin = vertices[polygon[0]];
    DVec3 normal(0);  // Newell's: twice the area vector
    for (std::size_t i = 0; i < polygon.size(); ++i)
        normal += glm::cross(DVec3(vertices[polygon[i]]) - origin,
                             DVec3(vertices[polygon[(i + 1) % polygon.size()]]) - origin);
    const DVec3 size = glm::abs(normal);
    const int dropped = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    int u = (dropped + 1) % 3, v = (dropped + 2) % 3;
    if (normal[dropped] < 0) std::swap(u, v);
    std::vector<DVec2> flat;
    for (const std::uint32_t corner : polygon) {
        const DVec3 p = DVec3(vertices[corner]) - origin;
        flat.emplace_back(p[u], p[v]);
    }
    return flat;
}

/// Twice the area of a triangle; positive if it turns counter-clockwise.
double area2(DVec2 a, DVec2 b, DVec2 c) {
    return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
}

class EarClipper {
public:
    EarClipper(std::vector<DVec2> points, std::span<const std::uint32_t> names)
        : points_(std::move(points)), names_(names) {
        for (std::size_t i = 0; i < points_.size(); ++i) ring_.push_back(i);
        for (std::size_t i = 0; i < ring_.size(); ++i) quality_.push_back(quality(i));
    }

    void clip(std::vector<Triangle>& triangles) {
        while (ring_.size() > 4) clip_ear(best_ear(), triangles);
        // The last cut makes two triangles: the better if its worse one is.
        const double even = std::min(quality_[0], quality_[2]);
        const double odd = std::min(quality_[1], quality_[3]);
        clip_ear(even >= odd ? 0 : 1, triangles);
        triangles.push_back({names_[ring_[0]], names_[ring_[1]], names_[ring_[2]]});
    }

private:
    DVec2 corner(std::size_t i) const { return points_[ring_[i % ring_.size()]]; }

    /// How well shaped an ear corner i is: its area over its longest edge squared; worst, -1, if
    /// it is none: no triangle on the inside, or others in its way.
    double quality(std::size_t i) const {
        const DVec2 a = corner(i + ring_.size() - 1), b = corner(i), c = corner(i + 1);
        const double area = area2(a, b, c);
        if (!(area > 0)) return area == 0 ? 0 : -1;
        for (std::size_t j = i + 2; j % ring_.size() != (i + ring_.size() - 1) % ring_.size(); ++j)
            if (const DVec2 p = corner(j);
                area2(a, b, p) >= 0 && area2(b, c, p) >= 0 && area2(c, a, p) >= 0)
                return -1;
        const double longest2 =
            std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
        return area / longest2;
    }

    std::size_t best_ear() const {
        return static_cast<std::size_t>(std::max_element(quality_.begin(), quality_.end()) -
                                        quality_.begin());
    }

    /// Clips corner i. Only its neighbours change: an ear that is in no other's way hides none.
    void clip_ear(std::size_t i, std::vector<Triangle>& triangles) {
        const std::size_t n = ring_.size(), previous = (i + n - 1) % n, next = (i + 1) % n;
        triangles.push_back({names_[ring_[previous]], names_[ring_[i]], names_[ring_[next]]});
        ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(i));
        quality_.erase(quality_.begin() + static_cast<std::ptrdiff_t>(i));
        const std::size_t after = i % ring_.size(), before = (after + n - 2) % (n - 1);
        quality_[before] = quality(before);
        quality_[after] = quality(after);
    }

    std::vector<DVec2> points_;
    std::span<const std::uint32_t> names_;  // [point] vertex
    std::vector<std::size_t> ring_;         // points not yet clipped
    std::vector<double> quality_;           // [place in ring_]
};

}  // namespace

void cut_polygon(std::span<const Vec3> vertices, std::span<const std::uint32_t> polygon,
                 std::vector<Triangle>& triangles) {
    EarClipper(flatten(vertices, polygon), polygon).clip(triangles);
}

}  // namespace tallow
