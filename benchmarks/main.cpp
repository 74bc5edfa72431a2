// SPDX-License-Identifier: Apache-2.0
// Benchmarks of the evaluator and of what it is made of, on one thread: what is compared here is
// code and instruction sets. How the whole scales with threads is for experiments/evaluator.py.
#include "benchmarks/benchmarks.h"
#include "common/base/parallel.h"

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    const tallow::ThreadLimit one_thread(1);
    tallow::register_kernel_benchmarks();
    tallow::register_traversal_benchmarks();
    tallow::register_build_benchmarks();
    tallow::register_grouping_benchmarks();
    tallow::register_irradiance_benchmarks();
    tallow::register_single_scatter_benchmarks();
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
}
