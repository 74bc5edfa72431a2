// SPDX-License-Identifier: Apache-2.0
// The kernel's table in SIMD: a cubic and its derivatives for each lane. Included once for every
// instruction set.
//
// Per-target include guard, as Highway asks for.
#if defined(TALLOW_SIMD_KERNEL_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TALLOW_SIMD_KERNEL_INL_H
#undef TALLOW_SIMD_KERNEL_INL_H
#else
#define TALLOW_SIMD_KERNEL_INL_H
#endif

#include "common/nbody/kernel_table.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace tallow {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A cubic for each lane, and where in it the lane is.
template <class D>
struct Cubic {
    hn::Vec<D> c0, c1, c2, c3, x;
    HWY_INLINE hn::Vec<D> value() const {
        return hn::MulAdd(x, hn::MulAdd(x, hn::MulAdd(x, c3, c2), c1), c0);
    }
    HWY_INLINE hn::Vec<D> first() const {
        const auto three_c3 = hn::Mul(hn::Set(D(), 3), c3);
        return hn::MulAdd(x, hn::MulAdd(x, three_c3, hn::Add(c2, c2)), c1);
    }
    /// With the absolute values of the coefficients: its value and derivatives bound all the terms
    /// that those of this one are added up from.
    HWY_INLINE Cubic absolute() const {
        return {hn::Abs(c0), hn::Abs(c1), hn::Abs(c2), hn::Abs(c3), x};
    }
    HWY_INLINE hn::Vec<D> second() const {
        const auto six_c3 = hn::Mul(hn::Set(D(), 6), c3);
        return hn::MulAdd(x, six_c3, hn::Add(c2, c2));
    }
};

template <class D>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> segment_index(D, const KernelTable::View& kernel,
                                                        hn::Vec<D> v) {
    const hn::RebindToUnsigned<D> du;
    const auto place = hn::ShiftRightSame(hn::BitCast(du, v), int(kernel.shift));
    const auto index = hn::Min(hn::Sub(place, hn::Set(du, kernel.first_index)),
                               hn::Set(du, kernel.size));  // the last one is 0
    return hn::BitCast(hn::RebindToSigned<D>(), index);
}

HWY_INLINE const KernelTable::Segment& segment_at(const KernelTable::Segment* segments,
                                                  std::uint32_t bytes) {
    return *reinterpret_cast<const KernelTable::Segment*>(reinterpret_cast<const char*>(segments) +
                                                          bytes);
}

#if HWY_TARGET == HWY_SCALAR
template <class D>
HWY_INLINE void load_cubics(D d, const KernelTable::Segment* segments, const std::uint32_t* offset,
                            Cubic<D>& cubic) {
    const KernelTable::Segment& s = segment_at(segments, *offset);
    cubic.c0 = hn::Set(d, s.c0), cubic.c1 = hn::Set(d, s.c1);
    cubic.c2 = hn::Set(d, s.c2), cubic.c3 = hn::Set(d, s.c3);
}

template <class D, class V>
HWY_INLINE hn::Vec<D> join(D, V low, V) {
    return low;  // never called: there is no half of one lane
}
#else
template <class D, class V>
HWY_INLINE hn::Vec<D> join(D d, V low, V high) {
    return hn::Combine(d, high, low);
}

// Rows of four to columns: within each 128-bit block, row i holds the coefficients of lane i.
template <class D>
HWY_INLINE void transpose(D d, hn::Vec<D> r0, hn::Vec<D> r1, hn::Vec<D> r2, hn::Vec<D> r3,
                          Cubic<D>& cubic) {
    const hn::Repartition<double, D> pairs;
    const auto low01 = hn::BitCast(pairs, hn::InterleaveLower(d, r0, r1));
    const auto low23 = hn::BitCast(pairs, hn::InterleaveLower(d, r2, r3));
    const auto high01 = hn::BitCast(pairs, hn::InterleaveUpper(d, r0, r1));
    const auto high23 = hn::BitCast(pairs, hn::InterleaveUpper(d, r2, r3));
    cubic.c0 = hn::BitCast(d, hn::InterleaveLower(pairs, low01, low23));
    cubic.c1 = hn::BitCast(d, hn::InterleaveUpper(pairs, low01, low23));
    cubic.c2 = hn::BitCast(d, hn::InterleaveLower(pairs, high01, high23));
    cubic.c3 = hn::BitCast(d, hn::InterleaveUpper(pairs, high01, high23));
}

// A vector whose 128-bit block b is the segment of lane 4 b + first.
template <class D>
HWY_INLINE hn::Vec<D> load_row(D d, const KernelTable::Segment* segments,
                               const std::uint32_t* offset, std::size_t first) {
    if constexpr (hn::MaxLanes(D()) <= 4) {
        return hn::Load(d, &segment_at(segments, offset[first]).c0);
    } else {
        const hn::Half<D> half;
        return join(d, load_row(half, segments, offset, first),
                    load_row(half, segments, offset + hn::MaxLanes(half), first));
    }
}

// One load a lane, then shuffles: a coefficient at a time, gathers would load four times as often.
template <class D>
HWY_INLINE void load_cubics(D d, const KernelTable::Segment* segments, const std::uint32_t* offset,
                            Cubic<D>& cubic) {
    transpose(d, load_row(d, segments, offset, 0), load_row(d, segments, offset, 1),
              load_row(d, segments, offset, 2), load_row(d, segments, offset, 3), cubic);
}
#endif

template <class D>
HWY_INLINE Cubic<D> find_cubic(D d, const KernelTable::View& kernel, hn::Vec<D> u) {
    const hn::RebindToUnsigned<D> du;
    const auto v = hn::Add(u, hn::Set(d, kernel.offset));
    const auto start = hn::And(hn::BitCast(du, v), hn::Set(du, ~std::uint32_t(0) << kernel.shift));
    const auto lanes_index = segment_index(d, kernel, v);
    Cubic<D> cubic;
    cubic.x = hn::Sub(v, hn::BitCast(d, start));
    HWY_ALIGN std::uint32_t offset[hn::MaxLanes(D())];
    hn::Store(hn::ShiftLeft<4>(hn::BitCast(du, lanes_index)), du, offset);
    static_assert(sizeof(KernelTable::Segment) == 16);
    // Through memory: taken out of the register one by one they would cost as much as all the rest.
    asm volatile("" : "+m"(offset));
    load_cubics(d, kernel.segments, offset, cubic);
    return cubic;
}

template <class D>
HWY_INLINE hn::Vec<D> look_up(D d, const KernelTable::View& kernel, const float* bounds,
                              hn::Vec<D> u) {
    const auto v = hn::Add(u, hn::Set(d, kernel.offset));
    return hn::GatherIndex(d, bounds, segment_index(d, kernel, v));
}

}  // namespace HWY_NAMESPACE
}  // namespace tallow
HWY_AFTER_NAMESPACE();

#endif
