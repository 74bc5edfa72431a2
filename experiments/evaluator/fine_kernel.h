// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "common/optics/profile.h"

namespace tallow {

/// A profile in double that is quick to evaluate a billion times: `transport` itself takes 1.5 us.
/// Cubics through four values each on 256 segments an octave of r^2, found by the bits of a double.
///
/// Units    r2 [mm^2] -> R [1/mm^2], as Profile.
/// Error    measured in construction between the values, see max_relative_error().
class FineKernel {
public:
    explicit FineKernel(const Profile& profile);

    double operator()(double r2) const {
        const std::uint64_t index = (std::bit_cast<std::uint64_t>(r2) >> kShift) - kFirst;
        if (index >= segments_.size()) return r2 < 1 ? at_0_ : 0;  // wraps around below the first
        const double start = std::bit_cast<double>((index + kFirst) << kShift);
        const auto& s = segments_[index];
        const double x = r2 - start;
        return s[0] + x * (s[1] + x * (s[2] + x * s[3]));
    }

    /// Where R is above 1e-12 of its largest value at a distance of 1 um or more.
    double max_relative_error() const { return error_; }

private:
    static constexpr int kShift = 52 - 8;
    static constexpr int kLowest = -40, kHighest = 22;  // log2 of r2: 1 um to 2 m
    static constexpr std::uint64_t kFirst = std::uint64_t(1023 + kLowest) << 8;

    double at_0_, error_ = 0;
    std::vector<std::array<double, 4>> segments_;  // coefficients of powers of r2 - start
};

}  // namespace tallow
