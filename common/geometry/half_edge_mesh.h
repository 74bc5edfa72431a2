// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "common/geometry/mesh.h"

namespace tallow {

/// A triangle mesh that knows its neighbourhoods, held by OpenMesh: for the questions that a list
/// of triangles answers badly. Some 100 bytes a triangle, so that closed meshes do without.
class HalfEdgeMesh {
public:
    /// `mesh` must be an oriented two-manifold (is_oriented_manifold) without zero areas.
    explicit HalfEdgeMesh(const TriangleMesh& mesh);
    ~HalfEdgeMesh();
    HalfEdgeMesh(const HalfEdgeMesh&) = delete;
    HalfEdgeMesh& operator=(const HalfEdgeMesh&) = delete;

    struct BoundaryLoop {
        std::size_t edges = 0;
        double length = 0;  // mm
        Vec3 through;       // one of its vertices
    };
    std::vector<BoundaryLoop> boundary_loops() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace tallow
