// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "common/geometry/mesh.h"
#include "render/snell.h"

namespace tallow {

/// Light that many triangles are asked about: how it falls on x if nothing bends it.
struct BeamQuery {
    Vec3 x;             // mm
    Vec3 w;             // unit, from x towards the light
    float inverse_eta;  // outside / inside
    float reach;        // longest way inside, mm
    float turn;         // change of the offset per depth, for each mm of depth, 1/mm
};
BeamQuery beam_query(const Ends& ends, float reach);

/// What light from a place sees through a flat triangle is a beam, bent at the surface: there is a
/// path to x through the triangle exactly if x lies in it. The gate refuses most triangles of which
/// x is not in the beam, with one square root: x is moved back to the triangle's plane as if light
/// fell on the triangle in the direction w in which it falls on x.
///
///     offset = depth T(w),   T(w) = w_tan / (eta cos_t),   |dT / dw| <= 1 / (eta cos_c^3)
///
/// with the critical angle's cos_c^2 = 1 - 1 / eta^2. The light of a path falls on the triangle
/// from a direction that differs from w by no more than 1.15 depth / (cos_c distance): the path
/// turns by less than 90 degrees - asin(1 / eta), and its way inside is at most depth / cos_c.
///
/// Conservative: what it refuses has no path. Of light at infinity what it lets pass has one, but
/// for rounding.
class BeamGate {
public:
    BeamGate(const TriangleMesh& mesh, std::size_t triangle);

    bool may_hold(const BeamQuery& query) const {
        const Vec3 from = query.x - corner_;
        const float depth = -glm::dot(from, normal_), cos_o = glm::dot(query.w, normal_);
        // x behind the plane and the light before it give cos_o > 0.
        if (depth < -rounding_ || depth > query.reach || cos_o < -kRounding) return false;
        const float sin2 = (1 - cos_o * cos_o) * query.inverse_eta * query.inverse_eta;
        const float cos2 = 1 - sin2;
        if (cos2 < kGrazing) return true;
        const Vec3 on_plane =
            from + depth * normal_ +
            (depth * query.inverse_eta / std::sqrt(cos2)) * (query.w - cos_o * normal_);
        const float u = glm::dot(u_of_, on_plane), v = glm::dot(v_of_, on_plane);
        const float margin =
            steep_ * (rounding_ + std::abs(depth) * (kRounding / kGrazing + depth * query.turn));
        return u > -margin && v > -margin && u + v < 1 + margin;
    }

private:
    static constexpr float kRounding = 2e-6f;  // of a unit vector's product
    static constexpr float kGrazing = 1e-2f;   // cos_t^2 below which rounding is not followed

    Vec3 corner_, normal_;
    Vec3 u_of_, v_of_;  // barycentric coordinates of p are dot(u_of, p - corner), the same for v
    float steep_;       // barycentric coordinates per mm, at most
    float rounding_;    // of positions, mm
};

}  // namespace tallow
