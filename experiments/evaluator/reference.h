// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "experiments/evaluator/problem.h"

namespace tallow {

/// Plain sums over all samples in double, with the model's exact kernel, at some of the points.
struct Reference {
    std::vector<std::uint32_t> point;      // index into Problem::points, drawn with a fixed seed
    std::vector<std::array<double, 3>> M;  // [i] at points[point[i]], W/mm^2
    double mean = 0;                       // of M, over points and channels
};

Reference compute_reference(const Problem& problem, std::size_t count);

/// Errors |M - reference| of computed sums, over reference points and channels.
struct Errors {
    double rel_rmse;       // sqrt(mean of error^2) / mean
    double p99, max;       // of error / max(reference, 0.01 mean)
    std::int64_t outside;  // how many exceed their bound; 0 without bounds
};

/// M[channel][point], and bounds of the same shape or empty ones.
Errors compare(const Reference& reference, const std::array<std::vector<float>, 3>& M,
               const std::array<std::vector<float>, 3>& bound);

}  // namespace tallow
