// SPDX-License-Identifier: Apache-2.0
#include "experiments/evaluator/reference.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/check.h"
#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "experiments/evaluator/fine_kernel.h"

namespace tallow {
namespace {

constexpr std::uint64_t kSeed = 20;

// Darker points count as if they were so bright: relative errors there are nobody's concern.
constexpr double kDark = 0.01;

// The reference must be much better than the evaluator's table, 2e-5. Measured: 4e-8 for
// transport, 1e-9 for dipoles.
constexpr double kKernelError = 1e-6;

// `count` different indices below n, or all of them.
std::vector<std::uint32_t> choose(std::size_t n, std::size_t count) {
    std::vector<std::uint32_t> indices(n);
    std::iota(indices.begin(), indices.end(), 0u);
    count = std::min(count, n);
    for (std::size_t i = 0; i < count; ++i)  // the first steps of a shuffle
        std::swap(indices[i], indices[i + random_bits(kSeed, 0, i) % (n - i)]);
    indices.resize(count);
    std::sort(indices.begin(), indices.end());
    return indices;
}

double plain_sum(const FineKernel& kernel, std::span<const Vec3> positions,
                 std::span<const float> weights, Vec3 x) {
    double sum = 0;
    for (std::size_t j = 0; j < positions.size(); ++j) {
        const DVec3 d = DVec3(x) - DVec3(positions[j]);
        sum += double(weights[j]) * kernel(glm::dot(d, d));
    }
    return sum;
}

}  // namespace

Reference compute_reference(const Problem& problem, std::size_t count) {
    Reference result;
    result.point = choose(problem.points.size(), count);
    result.M.resize(result.point.size());
    for (std::size_t c = 0; c < 3; ++c) {
        const FineKernel kernel(*profile(problem, int(c)));
        TALLOW_CHECK(kernel.max_relative_error() < kKernelError, "error {}",
                     kernel.max_relative_error());
        parallel_for(result.point.size(), 1, [&](std::size_t i) {
            result.M[i][c] = plain_sum(kernel, problem.samples.position, problem.flux[c],
                                       problem.points[result.point[i]]);
        });
    }
    for (const auto& M : result.M)
        result.mean += (M[0] + M[1] + M[2]) / (3 * double(result.M.size()));
    return result;
}

Errors compare(const Reference& reference, const std::array<std::vector<float>, 3>& M,
               const std::array<std::vector<float>, 3>& bound) {
    std::vector<double> relative;
    double squares = 0;
    std::int64_t outside = 0;
    for (std::size_t i = 0; i < reference.point.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            const double exact = reference.M[i][c];
            const double error = std::abs(double(M[c][reference.point[i]]) - exact);
            squares += error * error;
            relative.push_back(error / std::max(exact, kDark * reference.mean));
            if (!bound[c].empty()) outside += !(error <= double(bound[c][reference.point[i]]));
        }
    std::sort(relative.begin(), relative.end());
    const std::size_t n = relative.size();
    return {std::sqrt(squares / double(n)) / reference.mean,
            relative[std::min(n - 1, std::size_t(0.99 * double(n)))], relative.back(), outside};
}

}  // namespace tallow
