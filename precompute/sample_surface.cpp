// SPDX-License-Identifier: Apache-2.0
// Surface -> samples: cut into cells, cluster the pieces that are smaller than the spacing, put the
// result in Morton order.
#include "precompute/sample_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/base/check.h"
#include "common/base/overloaded.h"
#include "common/base/parallel.h"
#include "common/cloud/morton.h"
#include "precompute/cluster_fragments.h"
#include "precompute/surface_cells.h"

namespace tallow {
namespace {

constexpr std::size_t kGrain = 4096;  // samples that one task takes

// Samples on their way to their places: cells as they are, then clusters.
struct CellList {
    std::vector<Cell> cells;
    std::vector<Cluster> clusters;

    std::size_t size() const { return cells.size() + clusters.size(); }
    Cluster operator[](std::size_t i) const {
        if (i >= cells.size()) return clusters[i - cells.size()];
        return {cells[i], cells[i].center};
    }
};

CellList mesh_cells(const TriangleMesh& mesh, float spacing) {
    MeshPieces pieces = cut_mesh(mesh, spacing);
    std::vector<Cluster> clusters = cluster_fragments(mesh, pieces, spacing);
    return {std::move(pieces.cells), std::move(clusters)};
}

SurfaceSamples sort_by_morton(const CellList& list) {
    std::vector<Vec3> centers(list.size());
    parallel_for(centers.size(), kGrain, [&](std::size_t i) { centers[i] = list[i].cell.center; });
    const std::vector<std::uint32_t> order = sorted_order(morton_codes(centers));
    SurfaceSamples samples{std::move(centers), std::vector<Vec3>(order.size()),
                           std::vector<float>(order.size()), std::vector<Vec3>(order.size())};
    parallel_for(order.size(), kGrain, [&](std::size_t i) {
        const Cluster sample = list[order[i]];
        samples.position[i] = sample.cell.center;
        samples.normal[i] = sample.cell.normal;
        samples.area[i] = sample.cell.area;
        samples.ray_origin[i] = sample.ray_origin;
    });
    return samples;
}

double mesh_area(const TriangleMesh& mesh) {
    std::vector<double> sums((mesh.triangles.size() + kGrain - 1) / kGrain, 0);
    parallel_for(sums.size(), 1, [&](std::size_t block) {
        const std::size_t end = std::min(mesh.triangles.size(), (block + 1) * kGrain);
        for (std::size_t t = block * kGrain; t < end; ++t) sums[block] += triangle_area(mesh, t);
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

double count_mesh_samples(const TriangleMesh& mesh, float spacing) {
    // Cubes hold some tens of samples each: those for 20 000 samples are enough to know their mean.
    constexpr double kEnough = 20000;
    const double h2 = double(spacing) * spacing;
    const auto every = std::uint64_t(std::max(1.0, mesh_area(mesh) / h2 / kEnough));
    const CubeSubset subset{spacing, every};
    const CountedPieces pieces =
        count_pieces(mesh, spacing, [&](const Cell& cell) { return subset.contains(cell); });
    const std::vector<Cluster> clusters = cluster_fragments(mesh, pieces.kept, spacing);
    double area = 0;
    for (const Cluster& cluster : clusters) area += double(cluster.cell.area);
    const double share = area > 0 ? pieces.kept.fragment_area / area : 0;
    return pieces.cells + share * double(clusters.size());
}

}  // namespace

SurfaceSamples sample_surface(const Surface& surface, float spacing) {
    TALLOW_CHECK(spacing > 0, "spacing {}", spacing);
    return sort_by_morton(
        std::visit(Overloaded{
                       [&](const TriangleMesh& mesh) { return mesh_cells(mesh, spacing); },
                       [&](const SphereSurface& sphere) {
                           return CellList{sphere_cells(sphere, spacing), {}};
                       },
                       [&](const PlaneSurface& plane) {
                           return CellList{plane_cells(plane, spacing), {}};
                       },
                       [&](const DiscSurface&) -> CellList {
                           TALLOW_CHECK(false, "a disc encloses no volume");
                           return {};
                       },
                   },
                   surface));
}

double count_samples(const Surface& surface, float spacing) {
    if (const auto* mesh = std::get_if<TriangleMesh>(&surface))
        return count_mesh_samples(*mesh, spacing);
    if (const auto* plane = std::get_if<PlaneSurface>(&surface))
        return count_plane_cells(*plane, spacing);
    return count_sphere_cells(std::get<SphereSurface>(surface), spacing);
}

WorkEstimate estimate_work(const Surface& surface, float spacing) {
    if (const auto* mesh = std::get_if<TriangleMesh>(&surface))
        return estimate_work(*mesh, spacing);
    return {surface_area(surface) / (double(spacing) * spacing), 0};
}

double surface_area(const Surface& surface) {
    if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) {
        return mesh_area(*mesh);
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
