// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "common/geometry/mesh.h"
#include "common/geometry/mesh_repair_steps.h"

namespace tallow {

/// A triangle mesh that knows its neighbourhoods, held by OpenMesh: for the questions that a list
/// of triangles answers badly.
class HalfEdgeMesh {
public:
    /// `mesh` must be an oriented two-manifold (is_oriented_manifold) without zero areas.
    explicit HalfEdgeMesh(const TriangleMesh& mesh);
    ~HalfEdgeMesh();
    HalfEdgeMesh(const HalfEdgeMesh&) = delete;
    HalfEdgeMesh& operator=(const HalfEdgeMesh&) = delete;

    /// Numbered in the order of their first triangles.
    Components components() const;

    struct BoundaryLoop {
        std::size_t edges = 0;
        double length = 0;  // mm
        Vec3 through;       // one of its vertices
    };
    std::vector<BoundaryLoop> boundary_loops() const;

    /// Mean over the triangles around each vertex, weighted by their angle there: unlike a mean by
    /// area it does not depend on how the surface is cut. Zero where the triangles cancel out.
    /// Source: Thuermer, Wuethrich 1998, "Computing Vertex Normals from Polygonal Facets".
    std::vector<Vec3> vertex_normals() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace tallow
