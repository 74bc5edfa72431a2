// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "common/geometry/mesh.h"
#include "common/geometry/mesh_io.h"

namespace tallow {

/// What was done to make a mesh out of a soup. All zero for a clean file.
struct RepairReport {
    std::size_t merged_vertices = 0;        ///< coincident vertices joined
    std::size_t unused_vertices = 0;        ///< vertices that no polygon used, dropped
    std::size_t degenerate_faces = 0;       ///< of zero area or with repeated corners, removed
    std::size_t duplicate_faces = 0;        ///< triangles over the same corners, dropped
    std::size_t fin_faces = 0;              ///< of small open sheets that hung on a closed body
    std::size_t split_vertices = 0;         ///< non-manifold vertices and edges taken apart
    std::size_t triangulated_polygons = 0;  ///< polygons of more than three corners, cut
    std::size_t flipped_faces = 0;          ///< faces turned to agree with their neighbours
    std::size_t flipped_components = 0;     ///< connected components turned to face outward
    std::size_t components = 0;             ///< connected components of the result
    std::size_t boundary_loops = 0;         ///< 0 for a closed mesh
    std::string boundary;                   ///< where the boundary is, in words; empty if closed

    bool changed_anything() const;
    std::string summary() const;  ///< one line for people, e.g. "merged 12 vertices, cut 8 quads"
};

/// How the normals of a mesh are chosen.
enum class Normals {
    automatic,  ///< smooth where the file carries normals, otherwise flat
    flat,       ///< each triangle its own
    smooth      ///< the file's, or else angle-weighted means at the vertices
};

struct RepairedMesh {
    TriangleMesh mesh;
    RepairReport report;
};

/// Makes an oriented two-manifold triangle mesh out of a soup, whatever the soup: each edge has one
/// triangle or two that run along it in opposite directions, the triangles around a vertex are one
/// fan, none has zero area. Joins coincident vertices, cuts polygons into triangles, drops flat and
/// repeated ones and fins (sheets that hang on a closed body and are small beside it), takes the
/// surface apart where more than two triangles meet in an edge, orients connected components
/// coherently and, where closed, outward (a cavity's shell faces into the cavity), sets normals. An
/// open mesh is not closed: the report says where it is open, and the caller decides whether that
/// is an error. A soup that is moved in is freed as early as can be.
///
/// Throws   InputError prefixed with `name` if nothing is left.
RepairedMesh repair_mesh(PolygonSoup soup, Normals normals, const std::string& name);

}  // namespace tallow
