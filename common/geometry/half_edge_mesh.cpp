// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/half_edge_mesh.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "common/base/check.h"

namespace tallow {

namespace {

using Halves = OpenMesh::TriMesh_ArrayKernelT<OpenMesh::DefaultTraitsDouble>;

DVec3 to_vec(const Halves::Point& p) { return {p[0], p[1], p[2]}; }

}  // namespace

// Handles of vertices and faces are the indices of the TriangleMesh.
struct HalfEdgeMesh::Impl {
    Halves mesh;

    DVec3 point(Halves::VertexHandle v) const { return to_vec(mesh.point(v)); }
    DVec3 along(Halves::HalfedgeHandle h) const {
        return point(mesh.to_vertex_handle(h)) - point(mesh.from_vertex_handle(h));
    }
    BoundaryLoop follow(Halves::HalfedgeHandle start, std::vector<bool>& seen) const;
};

HalfEdgeMesh::HalfEdgeMesh(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>()) {
    Halves& halves = impl_->mesh;
    halves.reserve(mesh.vertices.size(), mesh.triangles.size() * 3 / 2, mesh.triangles.size());
    for (const Vec3 p : mesh.vertices) halves.add_vertex({p.x, p.y, p.z});
    const auto vertex = [](std::uint32_t v) { return Halves::VertexHandle(static_cast<int>(v)); };
    for (const auto [a, b, c] : mesh.triangles) {
        const auto face = halves.add_face(vertex(a), vertex(b), vertex(c));
        TALLOW_CHECK(face.is_valid(), "triangle {} {} {} is not manifold", a, b, c);
    }
}

HalfEdgeMesh::~HalfEdgeMesh() = default;

HalfEdgeMesh::BoundaryLoop HalfEdgeMesh::Impl::follow(Halves::HalfedgeHandle start,
                                                      std::vector<bool>& seen) const {
    BoundaryLoop loop;
    loop.through = Vec3(point(mesh.from_vertex_handle(start)));
    Halves::HalfedgeHandle h = start;
    do {
        seen[static_cast<std::size_t>(h.idx())] = true;
        ++loop.edges;
        loop.length += glm::length(along(h));
        h = mesh.next_halfedge_handle(h);
    } while (h != start);
    return loop;
}

std::vector<HalfEdgeMesh::BoundaryLoop> HalfEdgeMesh::boundary_loops() const {
    std::vector<BoundaryLoop> loops;
    std::vector<bool> seen(impl_->mesh.n_halfedges(), false);
    for (const auto h : impl_->mesh.halfedges())
        if (h.is_boundary() && !seen[static_cast<std::size_t>(h.idx())])
            loops.push_back(impl_->follow(h, seen));
    return loops;
}

}  // namespace tallow
