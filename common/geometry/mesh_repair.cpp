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
TriangleMesh compact(TriangleSoup soup) {
    TriangleMesh mesh;
    mesh.vertices.reserve(soup.vertices.size());
    mesh.triangles = std::move(soup.triangles);
    std::vector<std::uint32_t> number(soup.vertices.size(), kNone);
    for (Triangle& triangle : mesh.triangles) {
        for (std::uint32_t& v : triangle) {
            if (number[v] == kNone) {
                number[v] = static_cast<std::uint32_t>(mesh.vertices.size());
                mesh.vertices.push_back(soup.vertices[v]);
            }
            v = number[v];
        }
    }
    return mesh;
}

/// Steps 3 to 6, if need be. Returns the half-edge across each.
std::vector<std::uint32_t> make_manifold(TriangleSoup& soup, RepairReport& report) {
    if (auto opposite = manifold_opposites(soup)) return std::move(*opposite);
    drop_duplicates(soup, report);
    drop_fins(soup, report);
    const std::vector<std::uint32_t> copy_of = orient_neighbours(soup, report);
    sew_slits(soup, copy_of, report);
    auto opposite = manifold_opposites(soup);
    TALLOW_CHECK(opposite, "{} triangles after repair", soup.triangles.size());
    return std::move(*opposite);
}

void describe_boundary(const TriangleMesh& mesh, RepairReport& report) {
    const std::vector<HalfEdgeMesh::BoundaryLoop> loops = HalfEdgeMesh(mesh).boundary_loops();
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

RepairedMesh repair_mesh(PolygonSoup file, Normals normals, const std::string& name) {
    RepairReport report;
    TriangleSoup soup = clean_soup(file, report);
    const bool smooth =
        normals == Normals::smooth || (normals == Normals::automatic && !file.normals.empty());
    const bool textured = !file.uvs.empty();
    if (!textured) file.polygons = {};  // frees more than the result takes
    if (!smooth && !textured) file = {};
    if (soup.triangles.size() > kMostTriangles)
        throw InputError(fmt::format("{}: expected at most {} triangles, got {}", name,
                                     kMostTriangles, soup.triangles.size()));
    remove_flat_triangles(soup, report);
    if (soup.triangles.empty()) throw InputError(name + ": no face of this mesh has an area");
    std::vector<std::uint32_t> opposite = make_manifold(soup, report);

    const std::vector<std::uint32_t> polygon = std::move(soup.polygon);
    RepairedMesh result{compact(std::move(soup)), {}};
    const Components components = connected_components(opposite);
    report.components = components.closed.size();
    opposite = {};
    if (std::ranges::count(components.closed, false) > 0) describe_boundary(result.mesh, report);
    const std::vector<bool> turned = face_outward(result.mesh, components, report);
    if (smooth)
        result.mesh.corner_normals =
            smooth_corner_normals(result.mesh, {components.of_triangle, turned}, file);
    if (textured) result.mesh.corner_uvs = find_corner_uvs(result.mesh, polygon, file);
    result.report = std::move(report);
    return result;
}

}  // namespace tallow
