// SPDX-License-Identifier: Apache-2.0
#pragma once

// Behind repair_mesh: the steps from a polygon soup to an oriented manifold, in their order. Each
// counts what it did in the report. Polygons are cut first, so that all further steps see nothing
// but triangles. No step moves a vertex.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/mesh.h"
#include "common/geometry/mesh_io.h"
#include "common/geometry/mesh_repair.h"

namespace tallow {

/// Triangles of three different vertices each; nothing else is promised.
struct TriangleSoup {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    // [triangle] the polygon of the file that it is part of; empty if the file has no uvs
    std::vector<std::uint32_t> polygon{};
};

/// Keeps triangle t where keep(t).
template <class Keep>
void keep_triangles(TriangleSoup& soup, Keep&& keep) {
    std::size_t kept = 0;
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        if (!keep(t)) continue;
        soup.triangles[kept] = soup.triangles[t];
        if (!soup.polygon.empty()) soup.polygon[kept] = soup.polygon[t];
        ++kept;
    }
    soup.triangles.resize(kept);
    if (!soup.polygon.empty()) soup.polygon.resize(kept);
}

/// Step 1: drops unused vertices, joins coincident ones, takes polygons that touch themselves in a
/// vertex apart there, cuts polygons into triangles (polygons over the same corners alike).
TriangleSoup clean_soup(const PolygonSoup& file, RepairReport& report);

/// Appends the triangles of a polygon of at least four different vertices, cut in the coordinate
/// plane that it covers most of, along its inside if it does not cross itself there. Time: its
/// corners squared.
void cut_polygon(std::span<const Vec3> vertices, std::span<const std::uint32_t> polygon,
                 std::vector<Triangle>& triangles);

/// Step 2: removes triangles without area so that no hole opens: their neighbours across the
/// longest edge are split at the vertex that lies on it.
void remove_flat_triangles(TriangleSoup& soup, RepairReport& report);

/// Whether the triangles are an oriented two-manifold as they are: each directed edge used once,
/// the triangles around each vertex one fan, no two triangles over the same vertices. Clean files
/// pass, and skip steps 3 to 6.
bool is_oriented_manifold(const TriangleSoup& soup);

/// The half-edge 3 t + c (see EdgeTable) across each, or none on a border, which is 2^32 - 1;
/// nothing if the triangles are no oriented two-manifold.
std::optional<std::vector<std::uint32_t>> manifold_opposites(const TriangleSoup& soup);

/// Step 3: drops all but the first of the triangles over the same vertices, whatever their order;
/// and the first too where there is one for each side and the surface is closed without them: the
/// sides of two bodies that touch, or of a sheet that hangs on one.
void drop_duplicates(TriangleSoup& soup, RepairReport& report);

/// Step 4: drops fins: sheets that hang with at least one free border on the edges of a closed
/// surface, enclose nothing, and are small beside it. Larger ones stay: they may be a body that was
/// left open, and the caller must hear of their border.
void drop_fins(TriangleSoup& soup, RepairReport& report);

/// Step 5: turns triangles to agree with their neighbours, most of a connected part staying as in
/// the file, and copies vertices where the surface is no manifold, so that it comes apart there:
/// afterwards is_oriented_manifold. Returns the vertex that each is a copy of (itself if of none).
std::vector<std::uint32_t> orient_neighbours(TriangleSoup& soup, RepairReport& report);

/// Step 6: closes the slits that step 5 left where a closed surface touches itself along edges.
/// Takes and keeps an oriented manifold.
void sew_slits(TriangleSoup& soup, std::span<const std::uint32_t> copy_of, RepairReport& report);

/// The connected components of a mesh.
struct Components {
    std::vector<std::uint32_t> of_triangle;  // [triangle] component
    std::vector<bool> closed;                // [component]
};

/// Components in the order of their first triangles, from the half-edges across each.
Components connected_components(std::span<const std::uint32_t> opposite);

/// Step 7: turns closed components to face away from the material: outward, or, inside an odd
/// number of others, into the cavity that they bound. Returns which have been turned.
std::vector<bool> face_outward(TriangleMesh& mesh, const Components& components,
                               RepairReport& report);

}  // namespace tallow
