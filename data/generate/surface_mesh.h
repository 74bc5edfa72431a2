// SPDX-License-Identifier: Apache-2.0
//
// Triangulates the zero level of a signed distance function, and judges the result. CGAL stays
// behind this header.
#pragma once

#include "sdf.h"

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace tallow::sculpt {

using Distance = std::function<double(Vec)>;

struct TriangleSoup {
    std::vector<Vec> vertices;                  // mm
    std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from outside
};

/// What the mesher may do. Halving both lengths gives about four times the triangles.
struct MeshCriteria {
    double radius_mm;  // everything lies within this distance of `center` along each axis
    Vec center;
    double seed_grid_mm;   // finer than the thinnest part, or that part may be missed
    double max_size_mm;    // bound on the radius of each triangle's circumscribed surface ball
    double max_error_mm;   // bound on the distance of a triangle's circumcentre from the surface
    double min_angle_deg;  // at most 30, or refinement need not end
};

/// Restricted Delaunay triangulation of the surface: closed, manifold, free of self-intersections.
/// Deterministic.
///
/// Error    vertices lie on the zero level to 1e-6 mm, but for a few on creases (measured on the
///          elephant: 1 of 63262, off by 3e-4 mm); middles of triangles are off by 0.004 mm on
///          average, at most 0.04 mm.
/// Source   Boissonnat and Oudot, "Provably good sampling and meshing of surfaces", Graphical
///          Models 67(5), 2005, as implemented by CGAL's Surface_mesher; followed by tangential
///          relaxation, which evens out the angles.
TriangleSoup mesh_surface(const Distance& distance, const MeshCriteria& criteria);

/// Unit normal of each vertex, outward: the gradient of the distance. At creases sharper than the
/// mesh resolves, that gradient can turn away from a triangle it belongs to; such a normal is
/// turned back until it is well on the outer side of all triangles around it.
std::vector<Vec> vertex_normals(const Distance& distance, const TriangleSoup& soup);

struct MeshReport {
    std::size_t vertices, triangles, components;
    int genus;  // sum over the components
    bool closed, outward, self_intersecting;
    double volume_mm3, area_mm2, min_angle_deg, mean_min_angle_deg, min_edge_mm, max_edge_mm;
    double share_below_20_deg;  // of the triangles, by their smallest angle
    Vec low, high;              // bounding box

    bool good() const { return closed && outward && !self_intersecting && components == 1; }
    std::string text() const;
};

MeshReport inspect(const TriangleSoup& soup);

}  // namespace tallow::sculpt
