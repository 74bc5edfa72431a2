// SPDX-License-Identifier: Apache-2.0
// The sums at 60k points of a shell, one channel: PointSum for every instruction set, certified and
// not, and the classical traversal with the same kernel.
#include <fmt/format.h>

#include <map>
#include <memory>

#include "benchmarks/benchmarks.h"
#include "benchmarks/shell.h"
#include "common/nbody/point_sum.h"
#include "common/nbody/solid_angle_sum.h"

namespace tallow {
namespace {

constexpr std::size_t kTargets = 60'000;
constexpr float kTolerances[] = {0.01f, 0.001f};
constexpr float kCertified = 0.01f;

// What the solid angle of [JB02] has to be for a relRMSE, as fitted in render/gather_exitance.cpp.
constexpr float kSolidAngleForTolerance = 6;

const std::vector<Vec3>& points() {
    static const std::vector<Vec3> made = seen_points(kTargets);
    return made;
}

PointSum& point_sum(std::size_t samples) {
    static std::map<std::size_t, std::unique_ptr<PointSum>> made;
    std::unique_ptr<PointSum>& sum = made[samples];
    if (!sum) {
        const Shell& body = shell(samples);
        sum = std::make_unique<PointSum>(body.position, body.weight, body.nodes, marble_table());
    }
    return *sum;
}

void report(benchmark::State& state, std::span<const float> evaluations) {
    double total = 0;
    for (const float count : evaluations) total += count;
    state.counters["time/point"] = time_each(evaluations.size());
    state.counters["evaluations/point"] = total / double(evaluations.size());
}

void evaluate(benchmark::State& state, const GroupSumFunctions& functions, float tolerance) {
    PointSum& sum = point_sum(std::size_t(state.range(0)));
    sum.use(functions);
    const TargetGroups targets(points(), sum.kernel().unit());
    std::vector<float> M(points().size()), evaluations(points().size());
    for (auto _ : state) {
        sum.evaluate(targets, tolerance, {M, evaluations});
        benchmark::DoNotOptimize(M.data());
    }
    report(state, evaluations);
}

void certify(benchmark::State& state, const GroupSumFunctions& functions, float tolerance) {
    PointSum& sum = point_sum(std::size_t(state.range(0)));
    sum.use(functions);
    const TargetGroups targets(points(), sum.kernel().unit());
    std::vector<float> M(points().size()), evaluations(M.size()), bound(M.size());
    PointSum::Certification result;
    for (auto _ : state) {
        result = sum.certify(targets, tolerance, {M, evaluations, bound});
        benchmark::DoNotOptimize(bound.data());
    }
    report(state, evaluations);
    state.counters["repeated"] = double(result.repeated) / double(M.size());
}

void traverse(benchmark::State& state, float solid_angle) {
    const Shell& body = shell(std::size_t(state.range(0)));
    const SolidAngleSum sum(body.position, body.weight, body.area, body.nodes);
    const KernelTable kernel = marble_table();
    std::vector<float> evaluations(points().size());
    for (auto _ : state)
        for (std::size_t i = 0; i < points().size(); ++i) {
            std::uint64_t calls = 0;
            benchmark::DoNotOptimize(sum.evaluate(points()[i], solid_angle, kernel, calls));
            evaluations[i] = float(calls);
        }
    report(state, evaluations);
}

template <class... Arguments>
void add(const std::string& name, Arguments&&... arguments) {
    benchmark::internal::Benchmark* added =
        benchmark::RegisterBenchmark(name.c_str(), std::forward<Arguments>(arguments)...);
    for (const std::int64_t samples : kSampleCounts) added->Arg(samples);
    added->Unit(benchmark::kMillisecond)->UseRealTime();
}

}  // namespace

void register_traversal_benchmarks() {
    for (const float tolerance : kTolerances) {
        for (const GroupSumFunctions& functions : all_group_sum_functions())
            add(fmt::format("traversal/evaluate/{}/{}", tolerance, functions.name), evaluate,
                functions, tolerance);
        add(fmt::format("traversal/solid angle/{}", tolerance), traverse,
            kSolidAngleForTolerance * tolerance);
    }
    for (const GroupSumFunctions& functions : all_group_sum_functions())
        add(fmt::format("traversal/certify/{}/{}", kCertified, functions.name), certify, functions,
            kCertified);
}

}  // namespace tallow
