// SPDX-License-Identifier: Apache-2.0
// In: a smooth function in double. Out: its C^2 cubic spline over knots that are the floats with
// few mantissa bits, in float, with bounds on the spline's derivatives. The spline is compared with
// the function; if it is not good enough it is built again with a smaller c, if the worst place is
// near the centre, or finer segments.
#include "common/nbody/kernel_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/check.h"

namespace tallow {
namespace {

constexpr double kEnd = 1e-12;       // of a profile's total per squared mean free path
constexpr double kSmallest = 1e-35;  // values below would be rounded as denormals
constexpr double kLight = 1e-6;      // part of the integral that may lie outside of the core
constexpr int kFewestBits = 3, kMostBits = 7;  // log2 of segments an octave
constexpr int kStepInwards = 3;                // c is divided by 8 at a time
constexpr int kSmallestOffset = -40;           // log2 of c in scales^2
constexpr double kFarthest = 0x1p80;           // units^2
constexpr double kProbes[] = {0.12, 0.5, 0.88};

// Of a segment of width w, over u.
double integral(const KernelTable::Segment& s, double w) {
    return w * (s.c0 + w * (s.c1 / 2.0 + w * (s.c2 / 3.0 + w * (s.c3 / 4.0))));
}

// 1 at the start of the last octave, 0 at its end, with two continuous derivatives.
double fade(double u, double end) {
    const double t = std::clamp(2 * u / end - 1, 0.0, 1.0);
    return 1 - t * t * t * (10 - t * (15 - 6 * t));
}

// log2 of u up to which the kernel is flat, within a tenth.
template <class Kernel>
int flat_exponent(const Kernel& kernel, int unit) {
    const double centre = kernel(0);
    int exponent = unit + 6;
    const auto changed = [&](int e) {
        return std::abs(kernel(std::ldexp(1.0, e)) - centre) > 0.1 * std::abs(centre);
    };
    while (exponent > unit + kSmallestOffset && changed(exponent)) --exponent;
    return exponent;
}

// Bounds of |a|, |b| over a segment, and whether a and b keep opposite signs.
struct CubicInCosine {
    double a_low, a_high, b_low, b_high;
    bool opposite;

    // Greatest |a c^3 + b c| over c in [0, 1].
    double greatest() const {
        if (!opposite) return a_high + b_high;
        double result = std::max(b_high - a_low, a_high - b_low);
        if (b_high < 3 * a_high)  // an extremum inside, at c^2 = |b / 3a|
            result = std::max(
                result, 2.0 / 3 * b_high * std::min(1.0, std::sqrt(b_high / (3 * a_low + 1e-300))));
        return result;
    }
};

}  // namespace

double KernelTable::unit_near(double length) { return std::exp2(std::floor(std::log2(length))); }

KernelTable::KernelTable(const Function& kernel, double scale, double unit, double negligible,
                         double wanted_error)
    : unit_(unit), to_units_(float(1 / (unit * unit))) {
    const double area = unit * unit;
    const Function in_units = [&](double u) { return area * kernel(u * area); };
    const int scale_exponent = int(std::floor(2 * std::log2(scale / unit)));
    int exponent = flat_exponent(in_units, scale_exponent), bits = kFewestBits;
    const double end = std::max(negligible * area, kSmallest);
    for (;;) {
        build(in_units, exponent, bits, end);
        measure(in_units);
        if (relative_error_ <= wanted_error) break;
        const bool near_centre = start_of(worst_segment_) < 2 * double(offset_);
        const bool inwards = near_centre && exponent > scale_exponent + kSmallestOffset;
        const std::size_t grown =
            inwards ? size() + (std::size_t(kStepInwards) << bits) : 2 * size();
        if (grown > kMostSegments || (!inwards && bits == kMostBits)) break;
        inwards ? exponent -= kStepInwards : ++bits;
    }
    bound_derivatives();
    error_beyond_ /= area;
    range_ *= area;
}

void KernelTable::build(const Function& kernel, int exponent, int bits, double negligible) {
    offset_ = float(std::ldexp(1.0, exponent));
    shift_ = 23 - std::uint32_t(bits);
    first_index_ = std::bit_cast<std::uint32_t>(offset_) >> shift_;
    // The end is looked for octave by octave: kernels may be small for a while and large again.
    std::size_t segments = 0;
    const std::size_t octave = std::size_t(1) << bits;
    for (std::size_t i = 0; start_of(i) < kFarthest; i += octave)
        if (std::abs(kernel(start_of(i) - offset_)) > negligible) segments = i + 2 * octave;
    range_ = start_of(segments) - offset_;
    std::vector<double> knots, values;
    for (std::size_t i = 0; i <= segments; ++i) {
        knots.push_back(start_of(i));
        const double u = knots.back() - offset_;
        values.push_back(kernel(u) * fade(u, range_));
    }
    segments_.clear();
    if (segments > 0) solve(knots, values);
    total_ = 0;
    for (std::size_t i = 0; i < segments; ++i)
        total_ += std::numbers::pi * integral(segments_[i], knots[i + 1] - knots[i]);
    segments_.push_back({0, 0, 0, 0});
}

// The spline through (knots, values): its second derivative is continuous, its third continuous at
// the second knot, its first 0 at the last. A tridiagonal system in the slopes.
void KernelTable::solve(const std::vector<double>& x, const std::vector<double>& y) {
    const std::size_t n = x.size();
    std::vector<double> diagonal(n), upper(n), slope(n);
    const auto width = [&](std::size_t i) { return x[i + 1] - x[i]; };
    const auto chord = [&](std::size_t i) { return (y[i + 1] - y[i]) / width(i); };
    // Not-a-knot at the second knot, with the third slope eliminated.
    diagonal[0] = width(1);
    upper[0] = width(0) + width(1);
    slope[0] = ((width(0) + 2 * upper[0]) * width(1) * chord(0) + width(0) * width(0) * chord(1)) /
               upper[0];
    for (std::size_t i = 1; i < n; ++i) {
        const bool last = i + 1 == n;
        const double lower = last ? 0 : width(i);
        const double right = last ? 0 : 3 * (width(i) * chord(i - 1) + width(i - 1) * chord(i));
        const double factor = lower / diagonal[i - 1];
        diagonal[i] = (last ? 1 : 2 * (width(i - 1) + width(i))) - factor * upper[i - 1];
        upper[i] = last ? 0 : width(i - 1);
        slope[i] = right - factor * slope[i - 1];
    }
    slope[n - 1] /= diagonal[n - 1];
    for (std::size_t i = n - 1; i-- > 0;)
        slope[i] = (slope[i] - upper[i] * slope[i + 1]) / diagonal[i];
    for (std::size_t i = 0; i + 1 < n; ++i) {
        const double w = width(i), c = chord(i);
        segments_.push_back({float(y[i]), float(slope[i]),
                             float((3 * c - 2 * slope[i] - slope[i + 1]) / w),
                             float((slope[i] + slope[i + 1] - 2 * c) / (w * w))});
    }
}

void KernelTable::measure(const Function& kernel) {
    const std::size_t core = core_size();
    relative_error_ = 0;
    error_beyond_ = std::abs(kernel(range_));
    for (std::size_t i = 0; i < size(); ++i) {
        const double start = start_of(i), width = start_of(i + 1) - start;
        for (const double t : kProbes) {
            const float v = float(start + t * width), x = float(v - start);
            const Segment& s = segments_[i];
            const double ours = s.c0 + x * (s.c1 + x * (s.c2 + x * s.c3));
            const double exact = kernel(double(v) - offset_), error = std::abs(ours - exact);
            if (i >= core) {
                error_beyond_ = std::max(error_beyond_, error);
            } else if (error > relative_error_ * std::abs(exact)) {
                relative_error_ = error / std::abs(exact);
                worst_segment_ = i;
            }
        }
    }
}

void KernelTable::bound_derivatives() {
    third_.assign(segments_.size(), 0);
    first_.assign(segments_.size(), 0);
    double third = 0, first = 0;
    for (std::size_t i = size(); i-- > 0;) {
        const Segment& s = segments_[i];
        const double w = start_of(i + 1) - start_of(i);
        const double u_low = start_of(i) - offset_, u_high = start_of(i + 1) - offset_;
        const double r_low = std::sqrt(u_low), r_high = std::sqrt(u_high);
        // K' is at most its values at both ends and what K'' can add between.
        const double left = 2.0 * s.c2, right = left + 6 * w * double(s.c3);
        const double slope =
            std::max(std::abs(double(s.c1)), std::abs(s.c1 + w * (left + right) / 2)) +
            w * std::abs(right - left) / 8;
        const double k2_high = std::max(std::abs(left), std::abs(right));
        const double k2_low = left * right > 0 ? std::min(std::abs(left), std::abs(right)) : 0;
        const double k3 = 6 * std::abs(double(s.c3));
        const CubicInCosine cubic{8 * k3 * r_low * u_low, 8 * k3 * r_high * u_high,
                                  12 * k2_low * r_low, 12 * k2_high * r_high,
                                  left * right > 0 && left * s.c3 < 0};
        third = std::max(third, cubic.greatest());
        first = std::max(first, 2 * r_high * slope);
        third_[i] = std::nextafter(float(third), std::numeric_limits<float>::infinity());
        first_[i] = std::nextafter(float(first), std::numeric_limits<float>::infinity());
    }
}

float KernelTable::third_derivative_bound(float u) const {
    const std::uint32_t index =
        (std::bit_cast<std::uint32_t>(u + offset_) >> shift_) - first_index_;
    return third_[std::min(std::size_t(index), size())];
}

// v = u + c at the beginning of a segment; exact, for it is a float.
double KernelTable::start_of(std::size_t segment) const {
    return std::bit_cast<float>((first_index_ + std::uint32_t(segment)) << shift_);
}

// Number of segments that hold all but kLight of the integral, none of them faded.
std::size_t KernelTable::core_size() const {
    double outside = 0;
    std::size_t count = size();
    while (count > 0 && start_of(count) - offset_ > range_ / 2) --count;
    for (; count > 0; --count) {
        const double w = start_of(count) - start_of(count - 1);
        outside += std::numbers::pi * std::abs(integral(segments_[count - 1], w));
        if (outside > kLight * std::abs(total_)) break;
    }
    return count;
}

KernelTable tabulate(const Profile& profile, double mean_free_path, double unit) {
    const double end = kEnd * profile.total_reflectance() / (mean_free_path * mean_free_path);
    return KernelTable([&](double r2) { return profile(r2); }, mean_free_path, unit, end);
}

}  // namespace tallow
