// SPDX-License-Identifier: Apache-2.0
// Triangle -> its plane and barycentric coordinates, in float; many queries at once, for every
// instruction set that Highway knows for this architecture.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/beam_gate.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

#include <algorithm>
#include <cmath>

#include "hwy/highway.h"
#include "render/beam_gate.h"

HWY_BEFORE_NAMESPACE();
namespace tallow {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, BeamQueries::kMost>;
using Lanes = hn::Vec<Floats>;

constexpr float kRounding = 2e-6f;  // of a unit vector's product
constexpr float kGrazing = 1e-2f;   // least cos_t^2 for which rounding is followed

struct Lanes3 {
    Lanes x, y, z;
};

Lanes all(float value) { return hn::Set(Floats(), value); }

Lanes dot(const Lanes3& a, Vec3 b) {
    return hn::Add(hn::Add(hn::Mul(a.x, all(b.x)), hn::Mul(a.y, all(b.y))), hn::Mul(a.z, all(b.z)));
}

// a + s b
Lanes3 moved(const Lanes3& a, Lanes s, const Lanes3& b) {
    return {hn::Add(a.x, hn::Mul(s, b.x)), hn::Add(a.y, hn::Mul(s, b.y)),
            hn::Add(a.z, hn::Mul(s, b.z))};
}

Lanes3 moved(const Lanes3& a, Lanes s, Vec3 b) {
    return moved(a, s, Lanes3{all(b.x), all(b.y), all(b.z)});
}

Lanes length(const Lanes3& a) {
    return hn::Sqrt(hn::Add(hn::Add(hn::Mul(a.x, a.x), hn::Mul(a.y, a.y)), hn::Mul(a.z, a.z)));
}

/// Light that falls on a plane under cos_o: its squared cosine inside, not below kGrazing.
Lanes cos_t2_of(Lanes cos_o, Lanes inverse2) {
    const Lanes sin2 = hn::Sub(all(1), hn::Mul(cos_o, cos_o));
    return hn::Max(hn::Sub(all(1), hn::Mul(sin2, inverse2)), all(kGrazing));
}

// Of queries first, first + 1, ...; names are those of the header.
hn::Mask<Floats> held(const BeamGate& gate, const BeamQueries& q, std::size_t first) {
    const Floats d;
    const Lanes zero = hn::Zero(d), one = all(1), inverse_eta = all(q.inverse_eta);
    const Lanes inverse2 = hn::Mul(inverse_eta, inverse_eta);
    const Lanes3 from = {hn::Sub(hn::Load(d, &q.x[first]), all(gate.corner.x)),
                         hn::Sub(hn::Load(d, &q.y[first]), all(gate.corner.y)),
                         hn::Sub(hn::Load(d, &q.z[first]), all(gate.corner.z))};
    const Lanes3 w = {hn::Load(d, &q.wx[first]), hn::Load(d, &q.wy[first]),
                      hn::Load(d, &q.wz[first])};
    const Lanes depth = hn::Neg(dot(from, gate.normal)), cos_o = dot(w, gate.normal);
    const Lanes deep = hn::Max(depth, zero);
    // From the corner to where light that comes from `a` would meet the plane.
    const auto met = [&](const Lanes3& a) {
        const Lanes cosine = dot(a, gate.normal);
        const Lanes along =
            hn::Div(hn::Mul(deep, inverse_eta), hn::Sqrt(cos_t2_of(cosine, inverse2)));
        return moved(moved(from, depth, gate.normal), along,
                     moved(a, hn::Neg(cosine), gate.normal));
    };
    const Lanes nearness = hn::Load(d, &q.nearness[first]);
    const Lanes3 p0 = met(w), back = moved(from, all(-1), p0);
    Lanes3 w1 = moved(w, nearness, back);
    const Lanes scale = hn::Div(one, length(w1));
    w1 = {hn::Mul(w1.x, scale), hn::Mul(w1.y, scale), hn::Mul(w1.z, scale)};
    const Lanes3 p1 = met(w1);
    const Lanes u = dot(p1, gate.u_of), v = dot(p1, gate.v_of);

    const Lanes turned = hn::Mul(hn::Mul(nearness, all(q.turn)), deep);
    const Lanes sin_o = hn::Sqrt(hn::Max(zero, hn::Sub(one, hn::Mul(cos_o, cos_o))));
    const Lanes sine = hn::Min(hn::Add(sin_o, turned), one);
    const Lanes least =
        hn::Max(hn::Sub(one, hn::Mul(hn::Mul(sine, sine), inverse2)), all(kGrazing));
    const Lanes slope = hn::Div(hn::Mul(deep, inverse_eta), hn::Mul(least, least));
    const Lanes contraction =
        hn::Min(hn::Div(hn::Mul(slope, nearness), hn::Max(hn::Sub(one, turned), all(0.1f))), one);
    const Lanes off = hn::Mul(hn::Mul(slope, turned), contraction);
    const Lanes margin = hn::Mul(
        all(gate.steep),
        hn::Add(hn::Add(all(gate.rounding), off), hn::Mul(deep, all(kRounding / kGrazing))));
    const Lanes inmost = hn::Min(hn::Min(u, v), hn::Sub(hn::Sub(one, u), v));
    // What is near grazing or near the light is not followed.
    const auto unknown = hn::Or(hn::Le(least, all(kGrazing)), hn::Ge(turned, all(0.5f)));
    const auto hit = hn::Or(hn::Ge(inmost, hn::Neg(margin)), unknown);
    const auto inside =
        hn::And(hn::Ge(depth, all(-gate.rounding)), hn::Le(depth, hn::Load(d, &q.reach[first])));
    // x behind the plane and the light before it give cos_o > 0.
    return hn::And(hn::And(hit, inside), hn::Ge(cos_o, all(-kRounding)));
}

std::uint32_t may_hold(const BeamGate& gate, const BeamQueries& queries) {
    const Floats d;
    std::uint32_t bits = 0;
    for (std::size_t first = 0; first < BeamQueries::kMost; first += hn::Lanes(d)) {
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(d, held(gate, queries, first), bytes);
        bits |= (std::uint32_t(bytes[0]) | std::uint32_t(bytes[1]) << 8) << first;
    }
    return bits;
}

}  // namespace HWY_NAMESPACE
}  // namespace tallow
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace tallow {

HWY_EXPORT(may_hold);

std::uint32_t BeamGate::may_hold(const BeamQueries& queries) const {
    return HWY_DYNAMIC_DISPATCH(may_hold)(*this, queries);
}

BeamQueries::BeamQueries(double eta)
    : x{}, y{}, z{}, wx{}, wy{}, wz{}, nearness{}, inverse_eta(float(1 / eta)) {
    constexpr double kOfAngle = 1.15;   // largest angle / sine, for angles below 48 degrees
    constexpr double kLeastCos = 1e-3;  // without refraction there is no bound
    const double cos_c = std::sqrt(std::max(0.0, 1 - 1 / (eta * eta)));
    longest_half = float(std::sqrt(std::max(0.0, eta * eta - 1)));
    turn = float(kOfAngle / std::max(cos_c, kLeastCos));
    reach.fill(-1);
}

void BeamQueries::set(std::size_t lane, const Ends& ends, float reach_of) {
    const DVec3 to_y = ends.y_at_infinity ? ends.y : ends.y - ends.x;
    const double distance = glm::length(to_y);
    const Vec3 w(to_y / distance);
    x[lane] = float(ends.x.x), y[lane] = float(ends.x.y), z[lane] = float(ends.x.z);
    wx[lane] = w.x, wy[lane] = w.y, wz[lane] = w.z;
    reach[lane] = reach_of;
    nearness[lane] = ends.y_at_infinity ? 0.0f : float(1 / distance);
}

BeamGate::BeamGate(const TriangleMesh& mesh, std::size_t triangle) {
    const auto& [a, b, c] = mesh.triangles[triangle];
    const DVec3 p(mesh.vertices[a]);
    const DVec3 e1 = DVec3(mesh.vertices[b]) - p, e2 = DVec3(mesh.vertices[c]) - p;
    const DVec3 across = glm::cross(e1, e2);
    const double area2 = glm::dot(across, across);
    const DVec3 of_u = glm::cross(e2, across) / area2, of_v = glm::cross(across, e1) / area2;
    corner = Vec3(p), normal = Vec3(glm::normalize(across));
    u_of = Vec3(of_u), v_of = Vec3(of_v);
    steep = float(std::max({glm::length(of_u), glm::length(of_v), glm::length(of_u + of_v)}));
    constexpr double kOfPosition = 1e-6;  // eight units in the last place of float
    rounding = float(kOfPosition * (glm::length(p) + glm::length(e1) + glm::length(e2)));
}

}  // namespace tallow

#endif
