// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "common/optics/profile.h"

namespace tallow {

/// A profile as the kernel of the evaluator: a few nanoseconds a call, in float.
///
/// The bits of the float u = r2 + c, with c a power of two, are the index: exponent and leading
/// mantissa bits choose a segment, the other mantissa bits are the place t in [0, 1) in it, where a
/// cubic in t gives R. Segments are thus fine where r is small and coarse where it is large, and
/// nothing is computed to find one. It ends where R has fallen below 1e-12 of the total per squared
/// mean free path, and is 0 beyond. R falls, but for rounding (4e-7 of its value).
///
/// Units    r2 [mm^2] -> R [1/mm^2].
/// Domain   any r2 >= 0; 0 for NaN and infinity.
///          A profile that nowhere exceeds 1e-35 / mm^2 becomes an empty table, 0 everywhere.
/// Error    measured in construction at three places a segment, see max_relative_error(). Segments
///          are refined until 2e-5 or until there would be more than kMostSegments; all models of
///          the twelve presets of data/materials.yaml reach 2e-5, with 200 to 1540 segments.
class ProfileTable {
public:
    static constexpr double kWantedError = 2e-5;
    static constexpr std::size_t kMostSegments = 4096;  // 64 kB

    /// `mean_free_path` [mm] sets the scale of the search; Profile itself does not know it.
    ProfileTable(const Profile& profile, double mean_free_path);

    float operator()(float r2) const {
        const auto bits = std::bit_cast<std::uint32_t>(r2 + offset_);
        const std::uint32_t index = (bits >> shift_) - first_;
        if (index >= segments_.size()) return 0;
        const float t = static_cast<float>(bits & mask_) * scale_;
        const Segment& s = segments_[index];
        return s.c0 + t * (s.c1 + t * (s.c2 + t * s.c3));
    }

    /// Integral of the table over the plane.
    double total_reflectance() const { return total_; }
    /// Largest relative error against the profile where all but 1e-6 of the light leaves.
    double max_relative_error() const { return relative_error_; }
    /// Largest error in 1/mm^2 farther out, up to the range and beyond.
    double max_error_beyond() const { return error_beyond_; }
    /// Squared distance in mm^2 from which on the table is 0.
    double range() const { return range_; }
    std::size_t size() const { return segments_.size(); }

private:
    struct alignas(16) Segment {
        float c0, c1, c2, c3;
    };

    void build(const Profile& profile, int exponent, int bits, double end);
    Segment fit(const Profile& profile, double start, double width) const;
    void measure(const Profile& profile);
    double start_of(std::size_t segment) const;
    std::size_t core_size() const;

    float offset_ = 0;         // c
    std::uint32_t shift_ = 0;  // 23 - log2(segments an octave)
    std::uint32_t mask_ = 0;
    std::uint32_t first_ = 0;  // index of the segment at r2 = 0
    float scale_ = 0;          // 2^-shift
    std::vector<Segment> segments_;
    double total_ = 0, relative_error_ = 0, error_beyond_ = 0, range_ = 0;
    std::size_t worst_segment_ = 0;
};

}  // namespace tallow
