// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/exitance_field.h"

#include <algorithm>

#include "common/base/parallel.h"

namespace tallow {
namespace {

// Solid angle for a tolerance (relRMSE). Fitted: on the bunny, armadillo and elephant in marble the
// measured error is then 0.2 to 0.9 of the tolerance between 0.0003 and 0.1; doubled, it exceeds
// the tolerance on the bunny (docs/results/evaluator.csv, by experiments/evaluator.py).
float solid_angle_for(float tolerance) { return 6 * tolerance; }

}  // namespace

std::array<KernelTable, 3> tabulate_profiles(Model model, const Medium& medium, Orders orders) {
    const Rgb scale = medium.mean_free_path();
    const double unit = KernelTable::unit_near(mean(scale));
    const auto table = [&](int channel) {
        return tabulate(*make_profile(model, medium, channel, orders), scale[channel], unit);
    };
    return {table(0), table(1), table(2)};
}

ExitanceField::ExitanceField(const LitSamples& samples, std::array<KernelTable, 3> profiles,
                             ExitanceAccuracy accuracy)
    : accuracy_(accuracy), profiles_(std::move(profiles)) {
    using Criterion = ExitanceAccuracy::Criterion;
    const bool by_error = accuracy.criterion == Criterion::error && accuracy.tolerance > 0;
    std::vector<float> flux(samples.position.size());
    for (std::size_t c = 0; c < 3; ++c) {
        parallel_for(flux.size(), 8192,
                     [&](std::size_t i) { flux[i] = samples.E_t[i][int(c)] * samples.area[i]; });
        if (by_error)
            sums_[c] =
                std::make_unique<PointSum>(samples.position, flux, samples.nodes, profiles_[c]);
        else
            solid_angle_sums_[c] = std::make_unique<SolidAngleSum>(samples.position, flux,
                                                                   samples.area, samples.nodes);
    }
}

Exitance ExitanceField::gather(std::span<const ExitancePoint> points) const {
    Exitance result;
    result.M.resize(points.size());
    result.evaluations.resize(points.size());
    if (points.empty()) return result;
    if (sums_[0])
        gather_by_error(points, result);
    else
        gather_by_solid_angle(points, result);
    return result;
}

void ExitanceField::gather_by_error(std::span<const ExitancePoint> points, Exitance& result) const {
    std::vector<Vec3> positions(points.size());
    parallel_for(points.size(), 16384, [&](std::size_t i) { positions[i] = points[i].position; });
    const TargetGroups targets(positions, profiles_[0].unit());
    std::vector<float> sum(points.size()), bound, evaluations(points.size());
    if (accuracy_.certified) {
        bound.resize(points.size());
        result.bound.resize(points.size());
    }
    for (std::size_t c = 0; c < 3; ++c) {
        if (accuracy_.certified) {
            const auto certification =
                sums_[c]->certify(targets, accuracy_.tolerance, {sum, evaluations, bound});
            result.repeated += certification.repeated;
            result.uncertified += certification.uncertified;
        } else {
            sums_[c]->evaluate(targets, accuracy_.tolerance, {sum, evaluations});
        }
        parallel_for(points.size(), 16384, [&](std::size_t i) {
            result.M[i][int(c)] = std::max(sum[i], 0.0f);  // the exact sum cannot be below 0
            result.evaluations[i] += evaluations[i];
            if (accuracy_.certified) result.bound[i][int(c)] = bound[i];
        });
    }
}

void ExitanceField::gather_by_solid_angle(std::span<const ExitancePoint> points,
                                          Exitance& result) const {
    const float solid_angle = solid_angle_for(accuracy_.tolerance);
    parallel_for(points.size(), 64, [&](std::size_t i) {
        std::uint64_t calls = 0;
        for (std::size_t c = 0; c < 3; ++c)
            result.M[i][int(c)] = float(solid_angle_sums_[c]->evaluate(
                points[i].position, solid_angle, profiles_[c], calls));
        result.evaluations[i] = float(calls);
    });
}

}  // namespace tallow
