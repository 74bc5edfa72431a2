// SPDX-License-Identifier: Apache-2.0
//
// Closed components in, which contain which and therefore which way each must face out (repair
// step 7). CGAL answers whether a point is inside.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <limits>
#include <unordered_map>

#include "common/geometry/mesh_repair_steps.h"

namespace tallow {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;
using Sides = CGAL::Side_of_triangle_mesh<SurfaceMesh, Kernel>;

Point to_point(Vec3 p) { return {p.x, p.y, p.z}; }

/// A connected component.
struct Shell {
    std::vector<std::uint32_t> triangles;
    bool closed;
    double volume = 0;  // signed: negative if the triangles face inward
    DVec3 low{std::numeric_limits<double>::infinity()}, high{-low};
};

void measure(const TriangleMesh& mesh, Shell& shell) {
    const DVec3 origin = mesh.vertices[mesh.triangles[shell.triangles[0]][0]];
    for (const std::uint32_t t : shell.triangles) {
        DVec3 p[3];
        for (std::size_t c = 0; c < 3; ++c) {
            p[c] = mesh.vertices[mesh.triangles[t][c]];
            shell.low = glm::min(shell.low, p[c]);
            shell.high = glm::max(shell.high, p[c]);
        }
        shell.volume += glm::dot(p[0] - origin, glm::cross(p[1] - origin, p[2] - origin)) / 6;
    }
}

std::vector<Shell> make_shells(const TriangleMesh& mesh, const Components& components) {
    std::vector<Shell> shells;
    for (const bool closed : components.closed) shells.push_back({{}, closed});
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        shells[components.of_triangle[t]].triangles.push_back(t);
    for (Shell& shell : shells) measure(mesh, shell);
    return shells;
}

SurfaceMesh copy_shell(const TriangleMesh& mesh, const Shell& shell) {
    std::vector<Point> points;
    std::vector<Triangle> triangles;
    std::unordered_map<std::uint32_t, std::uint32_t> number;
    for (const std::uint32_t t : shell.triangles) {
        Triangle& copy = triangles.emplace_back();
        for (std::size_t c = 0; c < 3; ++c) {
            const std::uint32_t v = mesh.triangles[t][c];
            const auto next = static_cast<std::uint32_t>(points.size());
            const auto [entry, is_new] = number.try_emplace(v, next);
            if (is_new) points.push_back(to_point(mesh.vertices[v]));
            copy[c] = entry->second;
        }
    }
    SurfaceMesh copy;
    CGAL::Polygon_mesh_processing::polygon_soup_to_polygon_mesh(points, triangles, copy);
    return copy;
}

/// Whether a shell lies inside another: some of its vertices strictly, none outside. Shells that
/// cross each other are no cavities, which is why CGAL's own orient_to_bound_a_volume, which asks
/// a single vertex, is not used.
bool lies_inside(const TriangleMesh& mesh, const Shell& shell, const Sides& sides) {
    constexpr std::size_t kProbes = 32;
    const std::size_t step = std::max<std::size_t>(1, shell.triangles.size() / kProbes);
    bool inside = false;
    for (std::size_t i = 0; i < shell.triangles.size(); i += step) {
        const Vec3 p = mesh.vertices[mesh.triangles[shell.triangles[i]][0]];
        const CGAL::Bounded_side side = sides(to_point(p));
        if (side == CGAL::ON_UNBOUNDED_SIDE) return false;
        inside = inside || side == CGAL::ON_BOUNDED_SIDE;
    }
    return inside;
}

/// For each shell, the closed ones whose boxes lie in its own; none for an open shell.
std::vector<std::vector<std::size_t>> boxes_inside(const std::vector<Shell>& shells) {
    std::vector<std::size_t> order;  // of closed shells, by their boxes' lower x
    for (std::size_t k = 0; k < shells.size(); ++k)
        if (shells[k].closed) order.push_back(k);
    const auto low_x = [&](std::size_t k) { return shells[k].low.x; };
    std::ranges::sort(order, {}, low_x);
    std::vector<std::vector<std::size_t>> inside(shells.size());
    for (const std::size_t outer : order) {
        const Shell& o = shells[outer];
        const auto last = std::ranges::upper_bound(order, o.high.x, {}, low_x);
        for (auto k = std::ranges::lower_bound(order, o.low.x, {}, low_x); k != last; ++k)
            if (const Shell& i = shells[*k]; *k != outer &&
                                             glm::all(glm::lessThanEqual(o.low, i.low)) &&
                                             glm::all(glm::lessThanEqual(i.high, o.high)))
                inside[outer].push_back(*k);
    }
    return inside;
}

/// For each closed shell, how many others it lies inside of.
std::vector<int> nesting_depths(const TriangleMesh& mesh, const std::vector<Shell>& shells) {
    std::vector<int> depth(shells.size(), 0);
    const std::vector<std::vector<std::size_t>> candidates = boxes_inside(shells);
    for (std::size_t outer = 0; outer < shells.size(); ++outer) {
        if (candidates[outer].empty()) continue;
        const SurfaceMesh copy = copy_shell(mesh, shells[outer]);
        const Sides sides(copy);
        for (const std::size_t inner : candidates[outer])
            depth[inner] += lies_inside(mesh, shells[inner], sides);
    }
    return depth;
}

}  // namespace

std::vector<bool> face_outward(TriangleMesh& mesh, const Components& components,
                               RepairReport& report) {
    const std::vector<Shell> shells = make_shells(mesh, components);
    const std::vector<int> depth = nesting_depths(mesh, shells);
    std::vector<bool> turned(shells.size(), false);
    for (std::size_t k = 0; k < shells.size(); ++k) {
        const double outward = depth[k] % 2 == 0 ? shells[k].volume : -shells[k].volume;
        if (!shells[k].closed || outward >= 0) continue;
        for (const std::uint32_t t : shells[k].triangles)
            std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
        turned[k] = true;
        ++report.flipped_components;
    }
    return turned;
}

}  // namespace tallow
