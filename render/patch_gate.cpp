// SPDX-License-Identifier: Apache-2.0
// A part of a surface against many places and lights side by side, in float; for every instruction
// set that Highway knows for this architecture. What is tested and why: refraction_bound.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/patch_gate.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

#include <algorithm>
#include <cmath>

#include "hwy/highway.h"
#include "render/patch_gate.h"

HWY_BEFORE_NAMESPACE();
namespace tallow {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

using Floats = hn::CappedTag<float, BeamQueries::kMost>;
using Lanes = hn::Vec<Floats>;
using Mask = hn::Mask<Floats>;

constexpr float kSlack = 1e-5f;  // as in refraction_bound.cpp

Lanes all(float value) { return hn::Set(Floats(), value); }

struct Lanes3 {
    Lanes x, y, z;
};

Lanes dot(const Lanes3& a, Vec3 b) {
    return hn::Add(hn::Add(hn::Mul(a.x, all(b.x)), hn::Mul(a.y, all(b.y))), hn::Mul(a.z, all(b.z)));
}

Lanes length(const Lanes3& a) {
    return hn::Sqrt(hn::Add(hn::Add(hn::Mul(a.x, a.x), hn::Mul(a.y, a.y)), hn::Mul(a.z, a.z)));
}

// sqrt(1 - s^2)
Lanes cosine_of(Lanes s) {
    return hn::Sqrt(hn::Max(hn::Zero(Floats()), hn::Mul(hn::Sub(all(1), s), hn::Add(all(1), s))));
}

/// RefractionCull::Cone; `all_round` where the ball holds the end.
struct Cones {
    Lanes3 axis;
    Lanes cosine, sine, chord;
    Mask all_round;
};

Cones cones(const Lanes3& d, float radius) {
    const Lanes distance = length(d), r = all(radius);
    const Mask holds = hn::Ge(r, distance);
    const Lanes inverse = hn::Div(all(1), hn::Max(distance, all(1e-30f)));
    const Lanes sine = hn::Min(all(1), hn::Mul(r, inverse)), cosine = cosine_of(sine);
    const Lanes chord = hn::Mul(sine, hn::Sqrt(hn::Div(all(2), hn::Add(all(1), cosine))));
    return {{hn::Mul(d.x, inverse), hn::Mul(d.y, inverse), hn::Mul(d.z, inverse)},
            cosine,
            sine,
            chord,
            holds};
}

// Whether some normal of the bound makes less than a right angle with some direction of the cone,
// whose axis makes the cosine `facing` with the bound's.
Mask may_face(const PatchBound& bound, Lanes facing, const Cones& to) {
    const Lanes cos_cone = all(bound.cos_cone), sin_cone = all(bound.sin_cone);
    const Lanes widest = hn::Sub(hn::Mul(cos_cone, to.cosine), hn::Mul(sin_cone, to.sine));
    const Lanes least = hn::Neg(
        hn::Add(hn::Add(hn::Mul(sin_cone, to.cosine), hn::Mul(cos_cone, to.sine)), all(kSlack)));
    return hn::Or(hn::Le(widest, hn::Zero(Floats())), hn::Ge(facing, least));
}

// Of queries first, first + 1, ...
Mask passed(const PatchBound& bound, const BeamQueries& q, std::size_t first) {
    const Floats d;
    const Lanes3 x = {hn::Load(d, &q.x[first]), hn::Load(d, &q.y[first]), hn::Load(d, &q.z[first])};
    const Lanes3 w = {hn::Load(d, &q.wx[first]), hn::Load(d, &q.wy[first]),
                      hn::Load(d, &q.wz[first])};
    const Lanes nearness = hn::Load(d, &q.nearness[first]), reach = hn::Load(d, &q.reach[first]);
    const Lanes3 from = {hn::Sub(x.x, all(bound.center.x)), hn::Sub(x.y, all(bound.center.y)),
                         hn::Sub(x.z, all(bound.center.z))};
    const Cones to_x = cones(from, bound.radius);
    // Towards y, of lights at any distance: (x - center) / distance + w is along y - center.
    const auto scaled = [&](Lanes a, Lanes b) { return hn::Add(hn::Mul(a, nearness), b); };
    const Lanes3 toward = {scaled(from.x, w.x), scaled(from.y, w.y), scaled(from.z, w.z)};
    const Lanes far = length(toward);
    const Lanes sine = hn::Div(hn::Mul(all(bound.radius), nearness), hn::Max(far, all(1e-30f)));
    const Mask holds_y = hn::Ge(sine, all(1));
    const Lanes sine_y = hn::Min(all(1), sine), cosine_y = cosine_of(sine_y);
    const Lanes inverse = hn::Div(all(1), hn::Max(far, all(1e-30f)));
    const Cones to_y = {
        {hn::Mul(toward.x, inverse), hn::Mul(toward.y, inverse), hn::Mul(toward.z, inverse)},
        cosine_y,
        sine_y,
        hn::Mul(sine_y, hn::Sqrt(hn::Div(all(2), hn::Add(all(1), cosine_y)))),
        holds_y};

    Mask pass = hn::Le(length(from), hn::Add(reach, all(bound.radius)));
    pass = hn::And(pass, hn::Ge(reach, hn::Zero(d)));  // below 0 there is no query
    const bool normals = bound.cos_cone > 0;
    const Lanes facing_y = dot(to_y.axis, bound.axis), facing_x = dot(to_x.axis, bound.axis);
    if (normals) {
        pass = hn::And(pass, hn::Or(to_y.all_round, may_face(bound, facing_y, to_y)));
        pass = hn::And(pass, hn::Or(to_x.all_round, may_face(bound, hn::Neg(facing_x), to_x)));
    }
    const Lanes eta = all(1 / q.inverse_eta);
    const auto half = [&](Lanes a, Lanes b) { return hn::Add(hn::Mul(eta, a), b); };
    const Lanes3 h = {half(to_x.axis.x, to_y.axis.x), half(to_x.axis.y, to_y.axis.y),
                      half(to_x.axis.z, to_y.axis.z)};
    const Lanes long_h = length(h), off = half(to_x.chord, to_y.chord);
    Mask obeys = hn::Le(hn::Sub(long_h, off), all(q.longest_half + kSlack));
    if (normals) {
        const Lanes s = hn::Div(off, hn::Max(long_h, all(1e-30f)));
        const Lanes c = cosine_of(hn::Min(all(1), s));
        const Lanes along = hn::Neg(half(facing_x, facing_y));
        const Lanes least = hn::Sub(hn::Mul(hn::Sub(hn::Sub(hn::Mul(all(bound.cos_cone), c),
                                                            hn::Mul(all(bound.sin_cone), s)),
                                                    all(kSlack)),
                                            long_h),
                                    all(kSlack));
        obeys = hn::And(obeys, hn::Or(hn::Ge(off, long_h), hn::Ge(along, least)));
    }
    return hn::And(pass, hn::Or(hn::Or(to_x.all_round, to_y.all_round), obeys));
}

}  // namespace

std::uint32_t may_refract_lanes(const PatchBound& bound, const BeamQueries& queries) {
    const Floats d;
    std::uint32_t bits = 0;
    for (std::size_t first = 0; first < BeamQueries::kMost; first += hn::Lanes(d)) {
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(d, passed(bound, queries, first), bytes);
        bits |= (std::uint32_t(bytes[0]) | std::uint32_t(bytes[1]) << 8) << first;
    }
    return bits;
}

}  // namespace HWY_NAMESPACE
}  // namespace tallow
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace tallow {

HWY_EXPORT(may_refract_lanes);

std::uint32_t may_refract(const PatchBound& bound, const BeamQueries& queries) {
    return HWY_DYNAMIC_DISPATCH(may_refract_lanes)(bound, queries);
}

}  // namespace tallow

#endif
