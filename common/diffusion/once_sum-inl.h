// SPDX-License-Identifier: Apache-2.0
// Tree of sources -> those near a place, one by one, as points of discs, or many together -> their
// sum. SIMD over siblings, over points and over what is summed; compiled once for every instruction
// set.
//
// Per-target include guard, as Highway asks for.
#if defined(TALLOW_ONCE_SUM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TALLOW_ONCE_SUM_INL_H
#undef TALLOW_ONCE_SUM_INL_H
#else
#define TALLOW_ONCE_SUM_INL_H
#endif

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/diffusion/once_sum.h"
#include "hwy/contrib/math/math-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace tallow {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Ways = hn::CappedTag<float, OnceSources::kWidth>;
using WayVector = hn::Vec<Ways>;
using Siblings = hn::CappedTag<float, SumTree::kChildren>;
using SiblingVector = hn::Vec<Siblings>;
using SiblingMask = hn::Mask<Siblings>;

// Sources farther away than so many mean free paths do not matter: e^-6 of a tenth of the light.
constexpr float kFarthest = 6;

// A node acts as one where its radius is at most so much of its distance. Sheets: within 1 %.
constexpr float kNodeOpening = 0.2f;

// How much farther away than the body reaches, and how many mean free paths, a source may be.
constexpr float kReachSlack = 1.25f, kReachRoom = 0.25f;

// The middle of a disc is where it counts most: a place above that takes the whole disc's integral.
constexpr float kMiddle = 0.4f;  // of its radius

/// Finds what sends light to one place.
class OnceGatherer {
public:
    OnceGatherer(const OnceCloud& cloud, const OncePlace& place, OnceSources& near)
        : cloud_(cloud), place_(place), frame_(make_frame(place.normal)), near_(near) {}

    void run() { visit(0); }
    /// Of discs that the place is above the middle of.
    OnceSums above_middles() const { return above_; }

private:
    /// From some nodes or sources to the place.
    struct To {
        SiblingVector x, y, z, towards, distance;

        HWY_INLINE To(const OncePlace& place, SiblingVector of_x, SiblingVector of_y,
                      SiblingVector of_z)
            : x(hn::Sub(hn::Set(Siblings(), place.position.x), of_x)),
              y(hn::Sub(hn::Set(Siblings(), place.position.y), of_y)),
              z(hn::Sub(hn::Set(Siblings(), place.position.z), of_z)),
              towards(dot(place.normal)),
              distance(hn::Sqrt(hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z))))) {}
        HWY_INLINE SiblingVector dot(Vec3 v) const {
            const Siblings d;
            return hn::MulAdd(x, hn::Set(d, v.x),
                              hn::MulAdd(y, hn::Set(d, v.y), hn::Mul(z, hn::Set(d, v.z))));
        }
    };

    void visit(std::uint32_t index) {
        const SumTree::Block& block = cloud_.sources->blocks()[index];
        for (std::size_t lane = 0; lane < SumTree::kChildren; lane += hn::Lanes(Siblings()))
            visit(block, lane);
    }

    void visit(const SumTree::Block& block, std::size_t first_lane) {
        const Siblings d;
        const auto load = [&](const float* column)
                              HWY_ATTR { return hn::Load(d, column + first_lane); };
        const To to(place_, load(block.x), load(block.y), load(block.z));
        const auto radius = load(block.radius), weight = load(block.weight);
        const auto nearest = hn::Sub(to.distance, radius);
        const auto farthest = hn::Set(d, kFarthest * cloud_.mean_free_path);
        const auto counts = hn::And(hn::And(hn::Gt(weight, hn::Zero(d)), hn::Le(nearest, farthest)),
                                    hn::Gt(hn::Add(to.towards, radius), hn::Zero(d)));
        const auto is_small = hn::Le(radius, hn::Mul(hn::Set(d, kNodeOpening), to.distance));
        const auto wanted = hn::AndNot(hn::And(is_small, is_beyond(to, nearest)), counts);
        const auto as_one =
            hn::And(hn::And(wanted, is_small), hn::Gt(to.distance, hn::Set(d, cloud_.far())));
        add(to, weight, as_one, [&](std::size_t lane) {
            return cloud_.part_of(block.first[first_lane + lane], block.count[first_lane + lane]);
        });
        for_each_lane(hn::AndNot(as_one, wanted), [&](std::size_t lane) {
            const std::size_t node = first_lane + lane;
            if (block.child[node] != SumTree::kLeaf)
                visit(block.child[node]);
            else
                add_points(block.first[node], block.count[node]);
        });
    }

    // Behind a hollow. `nearest` is at most the length of the way.
    HWY_INLINE SiblingMask is_beyond(const To& to, SiblingVector nearest) const {
        const Siblings d;
        const auto length = hn::Max(to.distance, hn::Set(d, 1e-20f));
        const auto reach =
            hn::Add(hn::Set(d, place_.reach.even), hn::Div(to.dot(place_.reach.slope), length));
        return hn::Gt(nearest, hn::MulAdd(hn::Set(d, kReachSlack), hn::Max(reach, hn::Zero(d)),
                                          hn::Set(d, kReachRoom * cloud_.mean_free_path)));
    }

    void add_points(std::uint32_t first, std::uint32_t count) {
        const Siblings d;
        const std::size_t lanes = hn::Lanes(d);
        for (std::uint32_t k = 0; k < count; k += std::uint32_t(lanes)) {
            SiblingVector x, y, z, weight;
            hn::LoadInterleaved4(d, &cloud_.sources->points()[first + k].x, x, y, z, weight);
            const To to(place_, x, y, z);
            const auto counts = hn::And(hn::FirstN(d, std::min<std::size_t>(lanes, count - k)),
                                        hn::Gt(weight, hn::Zero(d)));
            const auto is_far = hn::Gt(to.distance, hn::Set(d, cloud_.far()));
            const auto leaves = hn::Gt(to.towards, hn::Zero(d));
            add(to, weight, hn::And(hn::And(counts, is_far), leaves), [&](std::size_t lane) {
                return cloud_.part_of(first + k + std::uint32_t(lane), 1);
            });
            for_each_lane(hn::And(hn::AndNot(is_far, counts), leaves),
                          [&](std::size_t lane) { add_disc(first + k + std::uint32_t(lane)); });
        }
    }

    void add_disc(std::uint32_t source) {
        const SumTree::Point& p = cloud_.sources->points()[source];
        const float part = cloud_.part_of(source, 1), radius = cloud_.cell_radius;
        const Vec3 way = place_.position - Vec3(p.x, p.y, p.z);
        const float height = glm::dot(way, place_.normal);
        if (length2(way) - height * height < kMiddle * kMiddle * radius * radius) {
            const float above = cloud_.above_middle(height);
            above_.all += p.weight * above, above_.part += part * above;
            return;
        }
        constexpr float kShare = 1.0f / OnceCloud::kDiscPoints;
        near_.make_room(OnceCloud::kDiscPoints);
        for (const Vec2& at : cloud_.disc)
            near_.add(way + at.x * frame_.s + at.y * frame_.t, kShare * p.weight, kShare * part);
    }

    template <class PartOf>
    HWY_INLINE void add(const To& to, SiblingVector weight, SiblingMask which,
                        const PartOf& part_of) {
        const Siblings d;
        near_.make_room(hn::Lanes(d));
        const std::size_t at = near_.count;
        if (cloud_.part_before.empty()) {
            hn::StoreU(hn::Zero(d), d, &near_.part[at]);
        } else {
            std::size_t k = at;
            for_each_lane(which, [&](std::size_t lane) { near_.part[k++] = part_of(lane); });
        }
        // Not CompressStore: to memory, some processors compress hundreds of times slower.
        hn::StoreU(hn::Compress(to.x, which), d, &near_.x[at]);
        hn::StoreU(hn::Compress(to.y, which), d, &near_.y[at]);
        hn::StoreU(hn::Compress(to.z, which), d, &near_.z[at]);
        hn::StoreU(hn::Compress(weight, which), d, &near_.weight[at]);
        near_.count += hn::CountTrue(d, which);
    }

    template <class Use>
    static HWY_INLINE void for_each_lane(SiblingMask which, const Use& use) {
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(Siblings(), which, bytes);
        for (unsigned bits = bytes[0]; bits != 0; bits &= bits - 1)
            use(std::size_t(std::countr_zero(bits)));
    }

    const OnceCloud& cloud_;
    const OncePlace& place_;
    Frame frame_;
    OnceSources& near_;
    OnceSums above_{0, 0};
};

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

OnceSums sum_ways(const OnceSources& sources, Vec3 normal, float mean_free_path, float eta) {
    const Ways d;
    auto all = hn::Zero(d), part = hn::Zero(d);
    for (std::size_t k = 0; k < sources.count; k += hn::Lanes(d)) {
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

OnceSums sum_once(const OnceCloud& cloud, const OncePlace& place, OnceSources& room) {
    room.count = 0;
    OnceGatherer gatherer(cloud, place, room);
    gatherer.run();
    room.close();
    const OnceSums sums = sum_ways(room, place.normal, cloud.mean_free_path, cloud.eta);
    const OnceSums above = gatherer.above_middles();
    return {sums.all + above.all, sums.part + above.part};
}

OnceSum once_function() { return sum_once; }

}  // namespace HWY_NAMESPACE
}  // namespace tallow
HWY_AFTER_NAMESPACE();

#endif
