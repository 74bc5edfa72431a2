// SPDX-License-Identifier: Apache-2.0
// Sorting the points of an image into groups of neighbours.
#include "benchmarks/benchmarks.h"
#include "benchmarks/shell.h"
#include "common/nbody/target_groups.h"

namespace tallow {
namespace {

void group(benchmark::State& state) {
    const std::vector<Vec3> points = seen_points(std::size_t(state.range(0)));
    double packets = 0;
    for (auto _ : state) {
        const TargetGroups targets(points, 0.5);
        benchmark::DoNotOptimize(targets.packets().data());
        packets = double(targets.packets().size());
    }
    state.counters["time/point"] = time_each(points.size());
    state.counters["points/packet"] = double(points.size()) / packets;
}

}  // namespace

void register_grouping_benchmarks() {
    benchmark::RegisterBenchmark("grouping", group)
        ->Arg(60'000)
        ->Arg(1'000'000)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
}

}  // namespace tallow
