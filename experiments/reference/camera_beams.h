// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "common/base/vec.h"
#include "common/geometry/mesh.h"
#include "experiments/reference/crossing.h"
#include "experiments/reference/distance_grid.h"

namespace tallow::reference {

/// What the camera sees through each flat triangle of a body: a beam, bent by Snell's law. A point
/// x inside is linked to the camera through a triangle exactly if it lies in the triangle's beam,
/// so that a grid of cells, each with the beams that touch it, finds all links of a point at once.
///
/// Beams end at the depth `reach`. Of obstacles is known which side of a triangle the camera is on,
/// and what trials found.
class CameraBeams {
public:
    /// How far light from the camera gets beyond the point p of a triangle, in the direction `w`
    /// inside, before it leaves the body again, mm; 0 if it does not get to p. From any thread.
    using Probe = std::function<float(std::uint32_t facet, Vec3 p, Vec3 w)>;

    /// `eta` inside / outside, >= 1; `cells` cover the mesh.
    CameraBeams(const TriangleMesh& mesh, double eta, DVec3 camera, const Cells& cells,
                double reach, const Probe& probe);

    /// Calls use(const CameraLink&) for every link from x that is not longer than `reach`, which
    /// may be less than that of the constructor.
    template <class Use>
    void links(Vec3 x, float reach, Use&& use) const {
        if (!cells_.holds(x)) return;
        const std::size_t cell =
            cells_.index(cells_.along(0, x.x), cells_.along(1, x.y), cells_.along(2, x.z));
        for (std::uint32_t i = first_[cell]; i < first_[cell + 1]; ++i) {
            const Gate& gate = gates_[entries_[i]];
            if (!gate.may_hold(x, reach)) continue;
            if (const std::optional<CameraLink> link = link_through(beams_[entries_[i]], x, reach))
                use(*link);
        }
    }

private:
    /// Refuses most points that are not in a beam, in float: x is moved along the refracted ray
    /// of the triangle's middle up to its plane.
    struct Gate {
        Vec3 corner;  // mm
        Vec3 normal;
        Vec3 along;       // refracted direction inwards over its cosine to -normal
        Vec3 u_of, v_of;  // barycentric coordinates of p are dot(u_of, p - corner), the same for v
        // By how much barycentric coordinates may miss for an x that is in the beam: at the
        // surface, and more for each mm of depth.
        float slack, slack_by_depth;
        bool may_hold(Vec3 x, float reach) const;
    };
    /// The same, exactly.
    struct Beam {
        DVec3 corner, normal, u_of, v_of;
        DVec3 foot;     // of the perpendicular from the camera on the triangle's plane
        double height;  // of the camera above the plane, mm
        double open;    // length up to which links are open, mm
        std::uint32_t facet;
    };

    void add(const TriangleMesh& mesh, std::uint32_t facet, DVec3 camera, double reach);
    double open_length(const TriangleMesh& mesh, const Beam& beam, DVec3 camera,
                       const Probe& probe) const;
    void sort_into_cells(const TriangleMesh& mesh, DVec3 camera, double reach);
    std::vector<std::uint32_t> cells_of(const TriangleMesh& mesh, const Beam& beam, DVec3 camera,
                                        double reach) const;
    std::optional<CameraLink> link_through(const Beam& beam, Vec3 x, float reach) const;

    Cells cells_;
    double eta_;
    std::vector<Gate> gates_;  // [beam]
    std::vector<Beam> beams_;
    std::vector<std::uint32_t> first_;    // [cell], index into entries_; one more than cells
    std::vector<std::uint32_t> entries_;  // beams
};

}  // namespace tallow::reference
