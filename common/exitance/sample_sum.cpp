// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/sample_sum.h"

#include "common/base/parallel.h"

namespace tallow {
namespace {

// Solid angle for a tolerance (relRMSE). Fitted: on the bunny, armadillo and elephant in marble the
// measured error is then 0.2 to 0.9 of the tolerance between 0.0003 and 0.1; doubled, it exceeds
// the tolerance on the bunny (docs/results/evaluator.csv, by experiments/evaluator.py).
float solid_angle_for(float tolerance) { return 6 * tolerance; }

bool by_groups(const ExitanceAccuracy& accuracy) {
    return accuracy.criterion == ExitanceAccuracy::Criterion::error && accuracy.tolerance > 0;
}

}  // namespace

SumTargets::SumTargets(std::vector<Vec3> positions, double unit, const ExitanceAccuracy& accuracy)
    : positions_(std::move(positions)) {
    if (by_groups(accuracy)) groups_.emplace(positions_, unit);
}

SampleSum::SampleSum(const Samples& samples, std::span<const float> weights, KernelTable kernel,
                     const ExitanceAccuracy& accuracy)
    : accuracy_(accuracy) {
    if (by_groups(accuracy)) {
        by_error_ =
            std::make_unique<PointSum>(samples.position, weights, samples.nodes, std::move(kernel));
    } else {
        by_solid_angle_ =
            std::make_unique<SolidAngleSum>(samples.position, weights, samples.area, samples.nodes);
        kernel_ = std::move(kernel);
    }
}

void SampleSum::evaluate(const SumTargets& targets, Result& result) const {
    const std::size_t n = targets.positions().size();
    result.sum.resize(n);
    result.evaluations.resize(n);
    result.bound.resize(by_error_ && accuracy_.certified ? n : 0);
    result.certification = {};
    if (!by_error_) {
        const float solid_angle = solid_angle_for(accuracy_.tolerance);
        parallel_for(n, 64, [&](std::size_t i) {
            std::uint64_t calls = 0;
            result.sum[i] = float(
                by_solid_angle_->evaluate(targets.positions()[i], solid_angle, *kernel_, calls));
            result.evaluations[i] = float(calls);
        });
    } else if (accuracy_.certified) {
        result.certification = by_error_->certify(targets.groups(), accuracy_.tolerance,
                                                  {result.sum, result.evaluations, result.bound});
    } else {
        by_error_->evaluate(targets.groups(), accuracy_.tolerance,
                            {result.sum, result.evaluations});
    }
}

}  // namespace tallow
