// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/surface.h"
#include "common/scene/light.h"
#include "render/beam_gate.h"
#include "render/refraction_tree.h"

namespace tallow {

/// A path from light to a point x inside a body, refracted once at `position` on its surface.
struct RefractedPath {
    Vec3 position;  ///< x_i, mm
    Vec3 n_g, n;    ///< geometric and shading normal there
    Vec3 w_i;       ///< from x_i towards the light
    Vec3 w_inside;  ///< from x_i towards x
    float inside;   ///< length from x_i to x, mm
    float outside;  ///< length from x_i to the light, mm; infinite for one at infinity
    float spread;   ///< see below
};

/// A point inside, a light, and the longest way inside, mm.
struct ConnectionQuery {
    Vec3 x;
    LightPoint y;
    float reach = kInfinity;
};

/// The refracted connections through one body's surface.
///
/// A light of intensity I at y gives at x, across the refracted ray, the irradiance
/// I F_t(cos_i) spread e^(-sigma_t inside) summed over all paths; parallel light of irradiance E
/// gives E in place of I. `spread` is |dOmega_y / dA_x| in 1/mm^2, or |dA_y / dA_x| for parallel
/// light, with curvature and interpolated normals taken into account; cos_i is that to the shading
/// normal, which does the refracting.
///
/// Meshes are searched by a hierarchy of balls and normal cones around x. At its end stands, for
/// flat triangles, a test whether x lies in the beam that the triangle makes of the light, for
/// smooth ones Newton's method;
/// ellipsoids the same way over their octants; planes, flat triangles and spheres are solved in the
/// plane of incidence. Obstacles are not considered, other parts of the surface included. A disc
/// encloses nothing and has no paths.
///
/// Domain   eta = inside / outside >= 1. `surface` must outlive this.
/// Error    positions to 1e-9 of the distance of x, in exact arithmetic. Two paths closer to each
///          other than 1e-6 of it count as one: x is then on a caustic, where spread is infinite.
/// Source   [WZHB09]
class RefractedConnections {
public:
    RefractedConnections(const Surface& surface, float eta);

    /// Those that are not longer inside than `reach`, mm; with planes and spheres, all.
    std::vector<RefractedPath> find(Vec3 x, const LightPoint& y, float reach = kInfinity) const;

    /// The same for many queries, calling use(index of the query, path); neighbours that are lit
    /// from about the same direction are searched together, so that many take less time each.
    using Use = std::function<void(std::size_t, const RefractedPath&)>;
    void find(std::span<const ConnectionQuery> queries, const Use& use) const;

    /// Whether a shorter reach makes it faster: on meshes.
    bool is_searched() const { return tree_.has_value(); }

private:
    const Surface& surface_;
    float eta_;
    std::optional<RefractionTree> tree_;  // of a mesh
    void find_together(const TriangleMesh& mesh, std::span<const ConnectionQuery> queries,
                       std::span<const std::uint32_t> group, const Use& use) const;

    // [place in the tree's order]
    std::vector<BeamGate> gates_;     // of a flat mesh
    std::vector<PatchBound> bounds_;  // of a smooth one
};

}  // namespace tallow
