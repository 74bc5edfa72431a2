// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <benchmark/benchmark.h>

#include <cstddef>

namespace tallow {

// Each registers the benchmarks of one subject, one file a subject.
void register_kernel_benchmarks();
void register_traversal_benchmarks();
void register_build_benchmarks();
void register_grouping_benchmarks();
void register_irradiance_benchmarks();
void register_single_scatter_benchmarks();

inline constexpr std::int64_t kSampleCounts[] = {50'000, 200'000, 1'000'000};

/// Counter: seconds for each of `count` items of an iteration.
inline benchmark::Counter time_each(std::size_t count) {
    using benchmark::Counter;
    return Counter(double(count), Counter::kIsIterationInvariantRate | Counter::kInvert);
}

}  // namespace tallow
