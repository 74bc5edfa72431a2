// SPDX-License-Identifier: Apache-2.0
// In: a profile in double. Out: cubics over the float bits of r2 + c. Each cubic takes the
// profile's value at both ends, so that the table is continuous, and at the two inner Lobatto
// points, where that leaves the least error. Then the table is compared with the profile; if it is
// not good enough it is built again with a smaller c, if the worst place is near the centre, or
// finer segments.
#include "common/optics/profile_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/check.h"

namespace tallow {
namespace {

constexpr double kEnd = 1e-12;                 // of the total per squared mean free path
constexpr double kSmallest = 1e-35;            // values below would be rounded as denormals
constexpr double kLight = 1e-6;                // part of the light that may lie outside of the core
constexpr int kFewestBits = 4, kMostBits = 7;  // log2 of segments an octave
constexpr int kStepInwards = 3;                // c is divided by 8 at a time
constexpr int kSmallestOffset = -40;           // log2 of c in mean free paths^2
constexpr double kInner = 0.27639320225002106;  // (1 - 1 / sqrt(5)) / 2, Lobatto's inner point
// The error of the cubic is extreme near these places, and 0 at the four it was taken from.
constexpr double kProbes[] = {0.12, 0.5, 0.88};
constexpr double kRounding = 4e-7;

// log2 of a squared radius up to which the profile is flat, within a tenth.
int flat_exponent(const Profile& profile, int unit) {
    const double centre = profile(0);
    int exponent = unit + 6;
    while (exponent > unit + kSmallestOffset && profile(std::ldexp(1.0, exponent)) < 0.9 * centre)
        --exponent;
    return exponent;
}

}  // namespace

ProfileTable::ProfileTable(const Profile& profile, double mean_free_path) {
    const double area = mean_free_path * mean_free_path;
    const double end = std::max(kEnd * profile.total_reflectance() / area, kSmallest);
    const int unit = int(std::floor(std::log2(area)));
    int exponent = flat_exponent(profile, unit), bits = kFewestBits;
    for (;;) {
        build(profile, exponent, bits, end);
        measure(profile);
        if (relative_error_ <= kWantedError) return;
        const bool near_centre = start_of(worst_segment_) < 2 * double(offset_);
        const bool inwards = near_centre && exponent > unit + kSmallestOffset;
        const std::size_t grown =
            inwards ? segments_.size() + (std::size_t(kStepInwards) << bits) : 2 * segments_.size();
        if (grown > kMostSegments || (!inwards && bits == kMostBits)) return;
        inwards ? exponent -= kStepInwards : ++bits;
    }
}

void ProfileTable::build(const Profile& profile, int exponent, int bits, double end) {
    offset_ = float(std::ldexp(1.0, exponent));
    shift_ = 23 - std::uint32_t(bits);
    mask_ = (1u << shift_) - 1;
    scale_ = 1.0f / float(1u << shift_);
    first_ = std::bit_cast<std::uint32_t>(offset_) >> shift_;
    segments_.clear();
    total_ = 0;
    for (double start = offset_; profile(start - offset_) > end;) {
        const double next = start_of(segments_.size() + 1);
        const Segment s = fit(profile, start, next - start);
        segments_.push_back(s);
        total_ += std::numbers::pi * (next - start) *
                  (s.c0 + double(s.c1) / 2 + double(s.c2) / 3 + double(s.c3) / 4);
        start = next;
    }
    range_ = start_of(segments_.size()) - offset_;
}

ProfileTable::Segment ProfileTable::fit(const Profile& profile, double start, double width) const {
    const auto value = [&](double t) { return profile(start - offset_ + t * width); };
    const double a = value(0), b = value(1);
    // Deviations from the chord at the inner points, written as t (1 - t) (p + q (2 t - 1)).
    const double left = value(kInner) - (a + kInner * (b - a));
    const double right = value(1 - kInner) - (b + kInner * (a - b));
    const double inner = kInner * (1 - kInner);
    double p = (left + right) / (2 * inner);
    double q = (right - left) / (2 * inner * (1 - 2 * kInner));
    // Slope b - a + p (1 - 2t) + q (-6 t^2 + 6 t - 1); if it rises anywhere, the chord must do.
    const auto slope = [&](double t) {
        return b - a + p * (1 - 2 * t) + q * (6 * t * (1 - t) - 1);
    };
    const double turn = q != 0 ? std::clamp(0.5 - p / (6 * q), 0.0, 1.0) : 0;
    if (std::max({slope(0), slope(1), slope(turn)}) > 0) p = q = 0;
    return {float(a), float(b - a + p - q), float(3 * q - p), float(-2 * q)};
}

void ProfileTable::measure(const Profile& profile) {
    const std::size_t core = core_size();
    relative_error_ = 0;
    error_beyond_ = profile(range_);
    double previous = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < segments_.size(); ++i) {
        const double start = start_of(i), width = start_of(i + 1) - start;
        for (const double t : kProbes) {
            const float r2 = float(start - offset_ + t * width);
            const double ours = (*this)(r2), exact = profile(r2), error = std::abs(ours - exact);
            TALLOW_CHECK(ours >= 0 && ours <= previous * (1 + kRounding),
                         "the table rises from {} to {} at r2 = {}", previous, ours, r2);
            previous = ours;
            if (i >= core) {
                error_beyond_ = std::max(error_beyond_, error);
            } else if (error > relative_error_ * exact) {
                relative_error_ = error / exact;
                worst_segment_ = i;
            }
        }
    }
}

// r2 + c at the beginning of a segment; exact, for it is a float.
double ProfileTable::start_of(std::size_t segment) const {
    return std::bit_cast<float>((first_ + std::uint32_t(segment)) << shift_);
}

// Number of segments that hold all but kLight of the light.
std::size_t ProfileTable::core_size() const {
    double outside = 0;
    std::size_t size = segments_.size();
    for (; size > 0; --size) {
        const Segment& s = segments_[size - 1];
        outside += std::numbers::pi * (start_of(size) - start_of(size - 1)) *
                   (s.c0 + s.c1 / 2 + s.c2 / 3 + s.c3 / 4);
        if (outside > kLight * total_) break;
    }
    return size;
}

}  // namespace tallow
