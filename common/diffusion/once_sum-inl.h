// SPDX-License-Identifier: Apache-2.0
// OnceSum, SIMD over the sources, compiled once for every instruction set.
//
// Per-target include guard, as Highway asks for.
#if defined(TALLOW_ONCE_SUM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TALLOW_ONCE_SUM_INL_H
#undef TALLOW_ONCE_SUM_INL_H
#else
#define TALLOW_ONCE_SUM_INL_H
#endif

#include "common/diffusion/once_sum.h"
#include "hwy/contrib/math/math-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace tallow {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Ways = hn::CappedTag<float, OnceSources::kWidth>;
using WayVector = hn::Vec<Ways>;

/// Twice the transmittance; `eta` is outside / inside. Nothing from outside or beyond the critical
/// angle.
HWY_INLINE WayVector twice_transmitted(WayVector mu, float eta) {
    const Ways d;
    const auto one = hn::Set(d, 1), index = hn::Set(d, eta);
    const auto sin2 = hn::Mul(hn::NegMulAdd(mu, mu, one), hn::Set(d, 1 / (eta * eta)));
    const auto cos2 = hn::Sub(one, sin2);
    const auto leaves = hn::And(hn::Gt(mu, hn::Zero(d)), hn::Gt(cos2, hn::Zero(d)));
    const auto cosine = hn::Sqrt(hn::Max(cos2, hn::Zero(d)));
    const auto ratio = [&](WayVector a, WayVector b)
                           HWY_ATTR { return hn::Div(hn::Sub(a, b), hn::Add(a, b)); };
    const auto p = ratio(hn::Mul(index, mu), cosine), s = ratio(mu, hn::Mul(index, cosine));
    return hn::IfThenElseZero(leaves, hn::Sub(hn::Set(d, 2), hn::MulAdd(p, p, hn::Mul(s, s))));
}

OnceSums sum_once(const OnceSources& sources, Vec3 normal, float mean_free_path, float eta) {
    const Ways d;
    auto all = hn::Zero(d), part = hn::Zero(d);
    for (std::size_t k = 0; k < sources.x.size(); k += hn::MaxLanes(d)) {
        const auto x = hn::LoadU(d, &sources.x[k]), y = hn::LoadU(d, &sources.y[k]),
                   z = hn::LoadU(d, &sources.z[k]);
        const auto u = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
        const auto inverse = hn::Div(hn::Set(d, 1), hn::Sqrt(u));
        const auto towards =
            hn::MulAdd(x, hn::Set(d, normal.x),
                       hn::MulAdd(y, hn::Set(d, normal.y), hn::Mul(z, hn::Set(d, normal.z))));
        const auto mu = hn::Mul(towards, inverse);
        const auto depth = hn::Mul(hn::Mul(u, inverse), hn::Set(d, -1 / mean_free_path));
        const auto decayed = hn::Exp(d, hn::Max(depth, hn::Set(d, -80)));
        const auto term = hn::Mul(hn::Mul(decayed, twice_transmitted(mu, 1 / eta)),
                                  hn::Mul(mu, hn::Mul(inverse, inverse)));
        all = hn::MulAdd(hn::LoadU(d, &sources.weight[k]), term, all);
        part = hn::MulAdd(hn::LoadU(d, &sources.part[k]), term, part);
    }
    return {0.5f * hn::GetLane(hn::SumOfLanes(d, all)),
            0.5f * hn::GetLane(hn::SumOfLanes(d, part))};
}

OnceSum once_function() { return sum_once; }

}  // namespace HWY_NAMESPACE
}  // namespace tallow
HWY_AFTER_NAMESPACE();

#endif
