// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "experiments/reference/camera_beams.h"
#include "experiments/reference/crossing.h"
#include "experiments/reference/distance_grid.h"

namespace tallow::reference {

/// A closed mesh of flat triangles filled with a medium, as walks and a fixed camera see it. The
/// only user of Embree here.
///
/// Rays take note of nothing but triangles that face the right way, leaving or entering: so they
/// need no offset from the triangle that they start on.
class MeshBody {
public:
    /// `eta` inside / outside; links to the camera are found up to the depth `reach`, in mm; about
    /// `cells` cells around the mesh hold distances and beams.
    MeshBody(const TriangleMesh& mesh, double eta, DVec3 camera, double reach, double cells);
    ~MeshBody();
    MeshBody(MeshBody&&) noexcept;
    MeshBody& operator=(MeshBody&&) noexcept;

    /// Whether links() reports every path that is refracted once and not longer than `reach`.
    static constexpr bool kLinksAll = true;

    bool holds(Vec3 x) const;

    std::optional<Crossing> enter(Vec3 origin, Vec3 direction, float length) const;
    std::optional<Crossing> leave(Vec3 origin, Vec3 direction, float length) const;

    /// Lower bound of the distance from an inner point to the surface; < 0 only for a point
    /// outside.
    float clearance(Vec3 x) const { return grid_->clearance(x); }

    /// Calls use(const CameraLink&) for every link from x, obstacles not considered.
    template <class Use>
    void links(Vec3 x, float reach, Use&& use) const {
        beams_->links(x, reach, use);
    }

    /// Whether links() from x reports the path through p on a triangle, `inside` long.
    bool links_path(Vec3, Vec3, float inside, float reach) const { return inside <= reach; }

    /// Whether the body itself leaves the path from x over the link to the camera open.
    bool is_clear(Vec3 x, const CameraLink& link) const;

private:
    struct Rays;
    float signed_distance(Vec3 x) const;
    bool is_seen(std::uint32_t facet, DVec3 p) const;

    std::unique_ptr<Rays> rays_;
    std::unique_ptr<DistanceGrid> grid_;
    std::unique_ptr<CameraBeams> beams_;
    DVec3 camera_;
};

}  // namespace tallow::reference
