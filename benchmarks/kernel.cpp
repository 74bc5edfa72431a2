// SPDX-License-Identifier: Apache-2.0
// One kernel evaluation: the dipole's formula in double and in float, the table in scalar code, and
// the table inside the evaluator, where a threshold of 0 makes it sum point by point.
#include <cmath>
#include <string>

#include "benchmarks/benchmarks.h"
#include "benchmarks/shell.h"
#include "common/base/rng.h"
#include "common/nbody/point_sum.h"
#include "common/optics/dipole.h"

namespace tallow {
namespace {

constexpr std::size_t kDistances = 4096;  // fit into the first cache

// Squared distances, evenly spread over the logarithm from 0.1 to 10 mm.
template <class F>
std::vector<F> squared_distances() {
    std::vector<F> r2(kDistances);
    for (std::size_t i = 0; i < r2.size(); ++i)
        r2[i] = F(std::pow(10.0f, 4 * to_unit_float(random_bits(2, 0, i)) - 2));
    return r2;
}

template <class F, class Kernel>
void evaluate_one_by_one(benchmark::State& state, const Kernel& kernel) {
    const std::vector<F> distances = squared_distances<F>();
    for (auto _ : state) {
        F sum = 0;
        for (const F r2 : distances) sum += kernel(r2);
        benchmark::DoNotOptimize(sum);
    }
    state.counters["time/evaluation"] = time_each(distances.size());
}

template <class F>
void dipole_formula(benchmark::State& state) {
    const auto channel = dipole_channel<F>(marble(), 1, mismatch_A(marble().eta));
    evaluate_one_by_one<F>(state, [&](F r2) { return diffuse_reflectance(channel, r2); });
}

void scalar_table(benchmark::State& state) { evaluate_one_by_one<float>(state, marble_table()); }

// So few samples that all are within the kernel's range: none is left out.
constexpr std::size_t kSources = 4096;

void simd_table(benchmark::State& state, const GroupSumFunctions& functions) {
    const Shell& body = shell(kSources);
    const PointSum sum(body.position, body.weight, body.nodes, marble_table());
    const TargetGroups targets(seen_points(256), sum.kernel().unit());
    GroupSumState group_state;
    const auto sum_all = [&] {
        for (const TargetGroups::Group& group : targets.groups()) {
            functions.sum(
                {sum.tree().blocks().data(), sum.tree().points().data(), sum.kernel().view(),
                 targets.packets().data() + group.first_packet, group},
                {0, 0}, group_state);
            benchmark::DoNotOptimize(group_state.packets.data());
        }
    };
    for (auto _ : state) sum_all();
    // Points that fill up a packet count, too: they take as long.
    state.counters["time/evaluation"] =
        time_each(kSources * TargetGroups::kPacketSize * targets.packets().size());
}

}  // namespace

void register_kernel_benchmarks() {
    benchmark::RegisterBenchmark("kernel/formula/double", dipole_formula<double>);
    benchmark::RegisterBenchmark("kernel/formula/float", dipole_formula<float>);
    benchmark::RegisterBenchmark("kernel/table/scalar", scalar_table);
    for (const GroupSumFunctions& functions : all_group_sum_functions())
        benchmark::RegisterBenchmark(
            (std::string("kernel/table/point by point/") + functions.name).c_str(), simd_table,
            functions);
}

}  // namespace tallow
