// SPDX-License-Identifier: Apache-2.0
//
// A polygon soup in, an oriented manifold triangle mesh and a report out: the steps of
// mesh_repair_steps.h in their order.

#include "common/geometry/mesh_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "common/base/check.h"
#include "common/base/errors.h"
#include "common/geometry/half_edge_mesh.h"
#include "common/geometry/mesh_normals.h"
#include "common/geometry/mesh_repair_steps.h"
#include "common/geometry/mesh_uvs.h"

namespace tallow {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// So that half-edges have 32-bit numbers even if flat triangles split all others: nine times as
// many.
constexpr std::size_t kMostTriangles = kNone / 32;

/// Numbers the vertices in the order of their first use, without those that nobody uses any more.
TriangleMesh compact(const TriangleSoup& soup) {
    TriangleMesh mesh;
    mesh.vertices.reserve(soup.vertices.size());
    mesh.triangles.reserve(soup.triangles.size());
    std::vector<std::uint32_t> number(soup.vertices.size(), kNone);
    for (Triangle triangle : soup.triangles) {
        for (std::uint32_t& v : triangle) {
            if (number[v] == kNone) {
                number[v] = static_cast<std::uint32_t>(mesh.vertices.size());
                mesh.vertices.push_back(soup.vertices[v]);
            }
            v = number[v];
        }
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

/// Steps 3 to 6.
void make_manifold(TriangleSoup& soup, RepairReport& report) {
    drop_duplicates(soup, report);
    drop_fins(soup, report);
    const std::vector<std::uint32_t> copy_of = orient_neighbours(soup, report);
    sew_slits(soup, copy_of, report);
    TALLOW_CHECK(is_oriented_manifold(soup), "{} triangles after repair", soup.triangles.size());
}

void describe_boundary(const HalfEdgeMesh& mesh, RepairReport& report) {
    const std::vector<HalfEdgeMesh::BoundaryLoop> loops = mesh.boundary_loops();
    report.boundary_loops = loops.size();
    if (loops.empty()) return;
    const auto& longest =
        *std::max_element(loops.begin(), loops.end(),
                          [](const auto& a, const auto& b) { return a.length < b.length; });
    report.boundary = fmt::format(
        "{} of {} edges, {:.3g} long, through ({:.6g}, {:.6g}, {:.6g})",
        loops.size() == 1 ? "boundary loop"
                          : fmt::format("{} boundary loops, the longest", loops.size()),
        longest.edges, longest.length, longest.through.x, longest.through.y, longest.through.z);
}

}  // namespace

RepairedMesh repair_mesh(const PolygonSoup& file, Normals normals, const std::string& name) {
    RepairReport report;
    TriangleSoup soup = clean_soup(file, report);
    if (soup.triangles.size() > kMostTriangles)
        throw InputError(fmt::format("{}: expected at most {} triangles, got {}", name,
                                     kMostTriangles, soup.triangles.size()));
    remove_flat_triangles(soup, report);
    if (soup.triangles.empty()) throw InputError(name + ": no face of this mesh has an area");
    if (!is_oriented_manifold(soup)) make_manifold(soup, report);

    RepairedMesh result{compact(soup), {}};
    const HalfEdgeMesh half_edges(result.mesh);
    describe_boundary(half_edges, report);
    const Components components = half_edges.components();
    report.components = components.closed.size();
    const std::vector<bool> turned = face_outward(result.mesh, components, report);
    const bool smooth =
        normals == Normals::smooth || (normals == Normals::automatic && !file.normals.empty());
    if (smooth)
        result.mesh.corner_normals =
            smooth_corner_normals(result.mesh, {components.of_triangle, turned}, half_edges, file);
    if (!file.uvs.empty())
        result.mesh.corner_uvs = find_corner_uvs(result.mesh, soup.polygon, file);
    result.report = std::move(report);
    return result;
}

}  // namespace tallow
