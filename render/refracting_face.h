// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "common/geometry/surface.h"
#include "render/refraction_bound.h"

namespace tallow {

using Corners = std::array<glm::dvec2, 3>;  // part of a face, in its parameters

/// A triangle with interpolated normals. p = p_0 + u (p_1 - p_0) + v (p_2 - p_0), n likewise and
/// normalised.
class SmoothTriangle {
public:
    SmoothTriangle(const TriangleMesh& mesh, std::size_t t);
    Patch at(glm::dvec2 uv) const;
    PatchBound bound(const Corners& corners) const;

private:
    DVec3 p_, dp_[2];
    DVec3 n_, dn_[2];  // before normalisation
};

/// An eighth of an ellipsoid: image of the part of the unit sphere whose coordinates have the signs
/// of `octant`'s three bits. (1 - u - v, u, v), normalised, is the point of the sphere.
class EllipsoidOctant {
public:
    EllipsoidOctant(const Affine& to_world, int octant);
    Patch at(glm::dvec2 uv) const;
    PatchBound bound(const Corners& corners) const;

private:
    DVec3 on_sphere(glm::dvec2 uv) const;

    glm::dmat3 linear_, to_normal_;  // sphere -> ellipsoid; sphere -> normal before normalisation
    DVec3 translation_;
    DVec3 q_, dq_[2];                  // on the octahedron
    double stretch_, stretch_normal_;  // at least the norms of linear_ and to_normal_
};

/// Appends all points of a face where light from y is refracted to x, each once: Newton's method
/// from the middle of every small part that `cull` lets pass. Only the normal's sides are checked.
/// A triangle's `bound` is that of the whole face and has been let pass.
void find_on_face(const SmoothTriangle& face, const PatchBound& bound, const Ends& ends,
                  const RefractionCull& cull, std::vector<Patch>& found);
void find_on_face(const EllipsoidOctant& face, const Ends& ends, const RefractionCull& cull,
                  std::vector<Patch>& found);

/// Appends `patch` unless a neighbouring face found the same point on their common edge.
void add_once(const Ends& ends, const Patch& patch, std::vector<Patch>& found);

}  // namespace tallow
