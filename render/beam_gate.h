// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/geometry/mesh.h"
#include "render/snell.h"

namespace tallow {

/// Lights and places that many triangles are asked about, side by side: how light falls on x if
/// nothing bends it.
struct BeamQueries {
    static constexpr std::size_t kMost = 16;

    alignas(64) std::array<float, kMost> x, y, z;  // mm
    std::array<float, kMost> wx, wy, wz;           // unit, from x towards the light
    std::array<float, kMost> reach;     // longest way inside, mm; below 0 where there is no query
    std::array<float, kMost> nearness;  // 1 / distance of the light, 1/mm; 0 at infinity
    float inverse_eta;                  // outside / inside
    float turn;                         // see BeamGate
    float longest_half;                 // sqrt(eta^2 - 1), see RefractionCull

    /// `eta` inside / outside; no queries yet.
    explicit BeamQueries(double eta);
    void set(std::size_t lane, const Ends& ends, float reach_of);
};

/// What light from a place sees through a flat triangle is a beam, bent at the surface: there is a
/// path to x through the triangle exactly if x lies in it. The gate refuses most triangles of which
/// x is not in the beam: x is moved back to the triangle's plane as if light fell on the triangle
/// in the direction w in which it falls on x, and once more with the direction at the place found,
///
///     p_0 = p(w),   p_1 = p(w_1),   w_1 from p_0 towards the light,
///     p(w) = foot + depth T(w),   T(w) = w_tan / (eta cos_t),   |dT / dw| <= 1 / (eta cos_t^3)
///
/// The light of a path falls on the triangle from a direction that differs from w by no more than
/// turned = turn depth / distance, turn = 1.15 / cos_c, with the critical angle's cos_c^2 =
/// 1 - 1 / eta^2: the path turns by less than 90 degrees - asin(1 / eta), and its way inside is at
/// most depth / cos_c. So p_0 is off by at most depth |dT / dw| turned, and p_1 by that times
/// depth |dT / dw| / (distance (1 - turned)). cos_t is the least over these directions.
///
/// Conservative: what it refuses has no path.
struct BeamGate {
    BeamGate(const TriangleMesh& mesh, std::size_t triangle);

    /// Bit i is set if query i may have a path.
    std::uint32_t may_hold(const BeamQueries& queries) const;

    Vec3 corner, normal;
    Vec3 u_of, v_of;  // barycentric coordinates of p are dot(u_of, p - corner), the same for v
    float steep;      // barycentric coordinates per mm, at most
    float rounding;   // of positions, mm
};

}  // namespace tallow
