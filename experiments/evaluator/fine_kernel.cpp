// SPDX-License-Identifier: Apache-2.0
#include "experiments/evaluator/fine_kernel.h"

#include <algorithm>
#include <cmath>

#include "common/base/parallel.h"

namespace tallow {
namespace {

constexpr double kNegligible = 1e-12;  // of the value at 0

// Newton's form through values at x = 0, w/3, 2w/3 and w, multiplied out.
std::array<double, 4> cubic_through(const std::array<double, 4>& y, double w) {
    const double h = w / 3;
    const double d1 = (y[1] - y[0]) / h;
    const double d2 = (y[2] - 2 * y[1] + y[0]) / (2 * h * h);
    const double d3 = (y[3] - 3 * y[2] + 3 * y[1] - y[0]) / (6 * h * h * h);
    return {y[0], d1 - h * d2 + 2 * h * h * d3, d2 - 3 * h * d3, d3};
}

}  // namespace

FineKernel::FineKernel(const Profile& profile) : at_0_(profile(0)) {
    segments_.resize(std::size_t(kHighest - kLowest) << 8);
    std::vector<double> errors(segments_.size());
    parallel_for(segments_.size(), 64, [&](std::size_t i) {
        const double start = std::bit_cast<double>((kFirst + i) << kShift);
        const double width = std::bit_cast<double>((kFirst + i + 1) << kShift) - start;
        std::array<double, 4> y;
        for (int k = 0; k < 4; ++k) y[std::size_t(k)] = profile(start + width * k / 3);
        segments_[i] = cubic_through(y, width);
        const double between = start + width / 6, exact = profile(between);
        if (exact > kNegligible * at_0_) errors[i] = std::abs((*this)(between) / exact - 1);
    });
    error_ = *std::max_element(errors.begin(), errors.end());
}

}  // namespace tallow
