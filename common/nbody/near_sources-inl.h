// SPDX-License-Identifier: Apache-2.0
// Sources that are near to few points, side by side: SIMD over the sources. Included once for every
// instruction set.
//
// Per-target include guard, as Highway asks for.
#if defined(TALLOW_NEAR_SOURCES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TALLOW_NEAR_SOURCES_INL_H
#undef TALLOW_NEAR_SOURCES_INL_H
#else
#define TALLOW_NEAR_SOURCES_INL_H
#endif

#include <algorithm>
#include <array>

#include "common/nbody/expansion-inl.h"
#include "common/nbody/group_sum.h"

HWY_BEFORE_NAMESPACE();
namespace tallow {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Columns of floats of one length, a whole number of registers, that grow in storage which is
/// kept.
template <std::size_t kColumns>
class Columns {
public:
    explicit Columns(std::vector<float>& storage) : storage_(storage) {}

    std::size_t size() const { return size_; }
    float* operator[](std::size_t column) { return storage_.data() + column * capacity_; }
    const float* operator[](std::size_t column) const {
        return storage_.data() + column * capacity_;
    }

    /// Room for so many entries in all, and a register more.
    void reserve(std::size_t size) {
        capacity_ = (size / kWidth + 2) * kWidth;
        if (storage_.size() < kColumns * capacity_) storage_.resize(kColumns * capacity_);
    }
    void grow(std::size_t count) { size_ += count; }
    /// Fills the last register with zeros.
    void close() {
        for (std::size_t c = 0; c < kColumns; ++c) std::fill_n((*this)[c] + size_, kWidth, 0.0f);
    }

private:
    static constexpr std::size_t kWidth = TargetGroups::kPacketSize;

    std::vector<float>& storage_;
    std::size_t size_ = 0, capacity_ = 0;
};

/// All that has to be summed one by one for a few points.
class NearSources {
public:
    explicit NearSources(GroupSumState& state)
        : points_(state.near_points), nodes_(state.near_nodes) {}

    void reserve(std::size_t points, std::size_t nodes) {
        points_.reserve(points);
        nodes_.reserve(nodes);
    }

    /// A run of points of a tree, with as many behind it as a register holds (SumTree::kPadding).
    HWY_INLINE void add_points(const SumTree::Point* points, std::uint32_t count) {
        const Points d;
        for (std::uint32_t j = 0; j < count; j += std::uint32_t(hn::MaxLanes(d))) {
            PointVector x, y, z, weight;
            hn::LoadInterleaved4(d, &points[j].x, x, y, z, weight);
            const std::size_t at = points_.size() + j;
            hn::StoreU(x, d, points_[0] + at), hn::StoreU(y, d, points_[1] + at);
            hn::StoreU(z, d, points_[2] + at), hn::StoreU(weight, d, points_[3] + at);
        }
        points_.grow(count);
    }

    HWY_INLINE void add_node(const SumTree::Block& block, std::size_t lane) {
        const float of_node[] = {block.x[lane],      block.y[lane],      block.z[lane],
                                 block.weight[lane], block.xx[lane],     block.yy[lane],
                                 block.zz[lane],     2 * block.xy[lane], 2 * block.xz[lane],
                                 2 * block.yz[lane]};
        for (std::size_t c = 0; c < kNodeColumns; ++c) nodes_[c][nodes_.size()] = of_node[c];
        nodes_.grow(1);
    }

    void close() { points_.close(), nodes_.close(); }

    HWY_INLINE float sum_at(float x, float y, float z, const KernelTable::View& kernel) const {
        const Points d;
        auto sum = hn::Zero(d);
        for (std::size_t k = 0; k < points_.size(); k += hn::MaxLanes(d)) {
            const auto u = Offset(points_, k, x, y, z).u;
            sum = hn::MulAdd(hn::LoadU(d, points_[3] + k), find_cubic(d, kernel, u).value(), sum);
        }
        for (std::size_t k = 0; k < nodes_.size(); k += hn::MaxLanes(d))
            sum = hn::Add(sum, of_nodes(k, Offset(nodes_, k, x, y, z), kernel));
        return total(d, sum);
    }

private:
    static constexpr std::size_t kPointColumns = 4, kNodeColumns = 10;

    /// From sources to a point.
    struct Offset {
        PointVector x, y, z, u;

        HWY_INLINE Offset(const auto& columns, std::size_t k, float px, float py, float pz) {
            const Points d;
            x = hn::Sub(hn::Set(d, px), hn::LoadU(d, columns[0] + k));
            y = hn::Sub(hn::Set(d, py), hn::LoadU(d, columns[1] + k));
            z = hn::Sub(hn::Set(d, pz), hn::LoadU(d, columns[2] + k));
            u = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
        }
    };

    // The terms of PointSums::add_node().
    HWY_INLINE PointVector of_nodes(std::size_t k, const Offset& d_,
                                    const KernelTable::View& kernel) const {
        const Points d;
        const auto column = [&](std::size_t c) HWY_ATTR { return hn::LoadU(d, nodes_[c] + k); };
        const Cubic<Points> cubic = find_cubic(d, kernel, d_.u);
        const auto k1 = cubic.first(), k2 = cubic.second();
        const auto xx = column(4), yy = column(5), zz = column(6);
        const auto of_x =
            hn::MulAdd(xx, d_.x, hn::MulAdd(column(7), d_.y, hn::Mul(column(8), d_.z)));
        const auto of_y = hn::MulAdd(yy, d_.y, hn::Mul(column(9), d_.z));
        const auto dqd =
            hn::MulAdd(of_x, d_.x, hn::MulAdd(of_y, d_.y, hn::Mul(hn::Mul(zz, d_.z), d_.z)));
        const auto trace = hn::Add(xx, hn::Add(yy, zz));
        const auto second = hn::MulAdd(k1, trace, hn::Mul(hn::Add(k2, k2), dqd));
        return hn::MulAdd(column(3), cubic.value(), second);
    }

    Columns<kPointColumns> points_;
    Columns<kNodeColumns> nodes_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tallow
HWY_AFTER_NAMESPACE();

#endif
