// SPDX-License-Identifier: Apache-2.0
// What is done once for a cloud: Morton order and octree in pass one, the tree of sums in pass two.
#include "benchmarks/benchmarks.h"
#include "benchmarks/shell.h"
#include "common/cloud/morton.h"
#include "common/nbody/sum_tree.h"
#include "precompute/build_octree.h"

namespace tallow {
namespace {

void sort_by_morton(benchmark::State& state) {
    const std::vector<Vec3> points = scattered_points(std::size_t(state.range(0)));
    for (auto _ : state) benchmark::DoNotOptimize(sorted_order(morton_codes(points)));
    state.counters["time/sample"] = time_each(points.size());
}

void octree(benchmark::State& state) {
    const Shell& body = shell(std::size_t(state.range(0)));
    for (auto _ : state) benchmark::DoNotOptimize(build_octree(body.position));
    state.counters["time/sample"] = time_each(body.position.size());
}

void sum_tree(benchmark::State& state) {
    const Shell& body = shell(std::size_t(state.range(0)));
    for (auto _ : state) {
        const SumTree tree(body.position, body.weight, body.nodes, 0.5);
        benchmark::DoNotOptimize(tree.blocks().data());
    }
    state.counters["time/sample"] = time_each(body.position.size());
}

void add(const char* name, void (*run)(benchmark::State&)) {
    benchmark::internal::Benchmark* added = benchmark::RegisterBenchmark(name, run);
    for (const std::int64_t samples : kSampleCounts) added->Arg(samples);
    added->Unit(benchmark::kMillisecond)->UseRealTime();
}

}  // namespace

void register_build_benchmarks() {
    add("build/morton sort", sort_by_morton);
    add("build/octree", octree);
    add("build/sum tree", sum_tree);
}

}  // namespace tallow
