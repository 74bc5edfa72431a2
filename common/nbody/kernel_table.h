// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/optics/profile.h"

namespace tallow {

/// A radial kernel K(u), u = r^2, as the evaluator uses it: one cubic a segment, found by the bits
/// of a float, with bounds on its derivatives.
///
/// The bits of v = u + c, with c a power of two, are the index: the exponent and the leading
/// mantissa bits choose a segment, and a cubic in x = v - (start of the segment) gives K. Segments
/// are fine where r is small and coarse where it is large, and nothing is computed to find one. The
/// cubics are an interpolating spline, twice continuously differentiable, so that Taylor's theorem
/// holds for the table itself and its remainders can be bounded from its coefficients: this is what
/// certificates rest on (docs/EVALUATOR.md). K may have any sign and need not fall.
///
/// Units    everything in SIMD code is in units of unit(), a power of two in mm near the kernel's
///          own scale: u in unit^2, K in 1/unit^2. operator() takes and gives mm^2 and 1/mm^2.
/// Domain   any u >= 0; K is 0 from range() on, and for NaN.
/// Error    measured in construction at kProbes places a segment against the function; refined
///          until kWantedError or until there would be more than kMostSegments.
class KernelTable {
public:
    static constexpr double kWantedError = 2e-5;
    static constexpr std::size_t kMostSegments = 4096;  // 64 kB

    struct alignas(16) Segment {
        float c0, c1, c2, c3;
    };

    /// What SIMD code needs to evaluate the table.
    struct View {
        const Segment* segments;    // [size + 1], the last is 0
        const float* third;         // [size + 1] see third_derivative_bound()
        const float* first;         // [size + 1] the same for the first derivative
        float offset;               // c
        std::uint32_t shift;        // 23 - log2(segments an octave)
        std::uint32_t first_index;  // index of the segment at u = 0
        std::uint32_t size;
    };

    /// `kernel` maps r^2 in mm^2 to 1/mm^2 and is smooth. `scale` [mm] is the distance over which
    /// it varies, `unit` [mm] the power of two to compute in. K is taken for 0 where |K| stays
    /// below `negligible` [1/mm^2]; towards there it is faded out over the last octave. Segments
    /// are refined until the relative error is at most `wanted_error`.
    KernelTable(const std::function<double(double)>& kernel, double scale, double unit,
                double negligible, double wanted_error = kWantedError);

    float operator()(float r2) const {
        const auto [s, x] = place(r2 * to_units_);
        return to_units_ * (s.c0 + x * (s.c1 + x * (s.c2 + x * s.c3)));
    }

    /// The segment that holds u [unit^2], and the place in it; past the end the segment is 0.
    struct Place {
        const Segment& segment;
        float x;
    };
    Place place(float u) const {
        const float v = u + offset_;
        const auto bits = std::bit_cast<std::uint32_t>(v);
        const std::size_t index = (bits >> shift_) - first_index_;
        if (index >= size()) return {segments_.back(), 0};
        return {segments_[index], v - std::bit_cast<float>(bits >> shift_ << shift_)};
    }

    /// Power of two near `length`, for tables and sums that are to share positions.
    static double unit_near(double length);

    View view() const {
        return {segments_.data(), third_.data(), first_.data(),        offset_,
                shift_,           first_index_,  std::uint32_t(size())};
    }
    double unit() const { return unit_; }
    std::size_t size() const { return segments_.size() - 1; }
    /// Integral of the table over the plane.
    double total() const { return total_; }
    /// Squared distance in mm^2 from which on the table is 0.
    double range() const { return range_; }
    /// Largest relative error against the function in the core: where all but 1e-6 of the integral
    /// lies, and before the function is faded out.
    double max_relative_error() const { return relative_error_; }
    /// Largest error in 1/mm^2 farther out, up to the range and beyond.
    double max_error_beyond() const { return error_beyond_; }
    /// Greatest |d^3/ds^3 K(|x + s e|^2)| over unit vectors e and all |x|^2 >= u, in 1/unit^5.
    float third_derivative_bound(float u) const;

private:
    using Function = std::function<double(double)>;

    void build(const Function& kernel, int exponent, int bits, double negligible);
    void solve(const std::vector<double>& knots, const std::vector<double>& values);
    void measure(const Function& kernel);
    void bound_derivatives();
    double start_of(std::size_t segment) const;
    std::size_t core_size() const;

    double unit_;
    float to_units_;  // 1 / unit^2
    float offset_ = 0;
    std::uint32_t shift_ = 0, first_index_ = 0;
    std::vector<Segment> segments_;
    std::vector<float> third_, first_;
    double total_ = 0, relative_error_ = 0, error_beyond_ = 0, range_ = 0;
    std::size_t worst_segment_ = 0;
};

/// The kernel of a profile; `mean_free_path` [mm] is the scale on which it varies. It ends where R
/// has fallen below 1e-12 of the total per squared mean free path.
KernelTable tabulate(const Profile& profile, double mean_free_path, double unit);

}  // namespace tallow
