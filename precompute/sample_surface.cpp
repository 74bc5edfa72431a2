// SPDX-License-Identifier: Apache-2.0
// Surface -> samples: cut into cells, cluster the cells that are much smaller than the spacing,
// put the result in Morton order.
#include "precompute/sample_surface.h"

#include <cmath>
#include <utility>

#include "common/base/check.h"
#include "common/base/overloaded.h"
#include "common/cloud/morton.h"
#include "precompute/surface_cells.h"

namespace tallow {
namespace {

// Cells below this fraction of spacing^2 are clustered. Chosen: bisection leaves none below 0.7, so
// that only triangles that came small are merged.
constexpr float kSmallCell = 0.25f;

// The side of a cube that a normal points through.
int dominant_side(Vec3 n) {
    const Vec3 a = glm::abs(n);
    const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    return 2 * axis + (n[axis] < 0);
}

void append_cell(SurfaceSamples& samples, const Cell& cell) {
    samples.position.push_back(cell.center);
    samples.normal.push_back(cell.normal);
    samples.area.push_back(cell.area);
    samples.ray_origin.push_back(cell.center);
}

// One sample for cells[order[first..last)]: exact area and centroid, area-weighted normal; light is
// gathered at the cell nearest to the centroid.
void append_cluster(SurfaceSamples& samples, const std::vector<Cell>& cells,
                    std::span<const std::uint32_t> members) {
    double area = 0;
    DVec3 center(0), normal(0);
    for (std::uint32_t i : members) {
        area += cells[i].area;
        center += double(cells[i].area) * DVec3(cells[i].center);
        normal += double(cells[i].area) * DVec3(cells[i].normal);
    }
    center /= area;
    const Cell* nearest = &cells[members[0]];
    for (std::uint32_t i : members)
        if (length2(cells[i].center - Vec3(center)) < length2(nearest->center - Vec3(center)))
            nearest = &cells[i];
    samples.position.push_back(Vec3(center));
    samples.normal.push_back(glm::length(normal) > 0 ? Vec3(glm::normalize(normal))
                                                     : nearest->normal);
    samples.area.push_back(float(area));
    samples.ray_origin.push_back(nearest->center);
}

// Cells cluster if they share this key: a cube of the size of the spacing and the side of a cube
// that their normals point through. The two faces of a thin sheet, or of a sharp edge, stay apart.
std::uint64_t cluster_key(const Cell& cell, Vec3 low, float spacing) {
    constexpr std::uint64_t kMask = (1ull << 20) - 1;  // a million cubes along an axis
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis)
        key =
            key << 20 | (std::uint64_t((double(cell.center[axis]) - low[axis]) / spacing) & kMask);
    return key << 3 | std::uint64_t(dominant_side(cell.normal));
}

void cluster_small_cells(SurfaceSamples& samples, const std::vector<Cell>& cells, float spacing) {
    if (cells.empty()) return;
    Vec3 low(kInfinity);
    for (const Cell& cell : cells) low = glm::min(low, cell.center);
    std::vector<std::uint64_t> keys(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) keys[i] = cluster_key(cells[i], low, spacing);
    const std::vector<std::uint32_t> order = sorted_order(keys);
    for (std::size_t first = 0; first < order.size();) {
        std::size_t last = first + 1;
        while (last < order.size() && keys[order[last]] == keys[order[first]]) ++last;
        append_cluster(samples, cells, std::span(order).subspan(first, last - first));
        first = last;
    }
}

template <class T>
void permute(std::vector<T>& values, std::span<const std::uint32_t> order) {
    std::vector<T> sorted(values.size());
    for (std::size_t i = 0; i < order.size(); ++i) sorted[i] = values[order[i]];
    values = std::move(sorted);
}

void sort_by_morton(SurfaceSamples& samples) {
    const std::vector<std::uint32_t> order = sorted_order(morton_codes(samples.position));
    permute(samples.position, order);
    permute(samples.normal, order);
    permute(samples.area, order);
    permute(samples.ray_origin, order);
}

}  // namespace

SurfaceSamples sample_surface(const Surface& surface, float spacing) {
    TALLOW_CHECK(spacing > 0, "spacing {}", spacing);
    const std::vector<Cell> cells =
        std::visit(Overloaded{
                       [&](const TriangleMesh& mesh) { return mesh_cells(mesh, spacing); },
                       [&](const SphereSurface& sphere) { return sphere_cells(sphere, spacing); },
                       [&](const PlaneSurface& plane) { return plane_cells(plane, spacing); },
                       [&](const DiscSurface&) -> std::vector<Cell> {
                           TALLOW_CHECK(false, "a disc encloses no volume");
                           return {};
                       },
                   },
                   surface);

    SurfaceSamples samples;
    std::vector<Cell> small;
    const bool mesh = std::holds_alternative<TriangleMesh>(surface);
    for (const Cell& cell : cells) {
        if (mesh && cell.area < kSmallCell * spacing * spacing)
            small.push_back(cell);
        else
            append_cell(samples, cell);
    }
    cluster_small_cells(samples, small, spacing);
    sort_by_morton(samples);
    return samples;
}

double surface_area(const Surface& surface) {
    if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) {
        double area = 0;
        for (std::size_t t = 0; t < mesh->triangles.size(); ++t) area += triangle_area(*mesh, t);
        return area;
    }
    if (const auto* plane = std::get_if<PlaneSurface>(&surface))
        return std::numbers::pi * double(plane->radius) * plane->radius;
    if (const auto* disc = std::get_if<DiscSurface>(&surface)) {
        const glm::mat3& l = disc->to_world.linear;
        return std::numbers::pi * glm::length(glm::cross(DVec3(l[0]), DVec3(l[1])));
    }
    double area = 0;
    const auto& sphere = std::get<SphereSurface>(surface);
    // A fixed fine cut of the ellipsoid: cells are exact integrals, so that 64 bands are plenty.
    const float stretch = glm::length(sphere.to_world.linear[0]) +
                          glm::length(sphere.to_world.linear[1]) +
                          glm::length(sphere.to_world.linear[2]);
    for (const Cell& cell : sphere_cells(sphere, stretch / 64)) area += cell.area;
    return area;
}

}  // namespace tallow
