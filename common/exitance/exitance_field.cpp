// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/exitance_field.h"

#include <algorithm>

#include "common/base/parallel.h"

namespace tallow {
namespace {

constexpr std::size_t kGrain = 16384;

// Bounds of the sum and of the control variate add up: each is asked for half of the tolerance.
constexpr float kCertifiedTerm = 0.5f;

// What smoothed kernels are asked for without certificates. Such a kernel is only as wide as a few
// nodes, whose errors have one sign, where PointSum was fitted to profiles with a peak. Measured on
// 168 planes of 576 to 29k samples, 0.35 to 20 mean free paths apart, tolerances from 0.003 to 0.1:
// up to 2.05 of what is asked for (at 0.01; docs/FINE_MEDIA.md has the table). It takes 1.5
// times the evaluations in the mean.
constexpr float kSmoothedTerm = 0.4f;

ExitanceAccuracy accuracy_of_terms(ExitanceAccuracy accuracy, const ExitanceKernels& kernels) {
    if (accuracy.certified)
        accuracy.tolerance *= kernels.needs_irradiance() ? kCertifiedTerm : 1;
    else
        accuracy.tolerance *= kernels.smoothed ? kSmoothedTerm : 1;
    return accuracy;
}

Vec3 tangential(Vec3 w, Vec3 n) { return w - glm::dot(w, n) * n; }

}  // namespace

ExitanceField::ExitanceField(const LitSamples& samples, std::array<KernelTable, 3> profiles,
                             ExitanceAccuracy accuracy)
    : ExitanceField({}, samples, ExitanceKernels{std::move(profiles)}, accuracy) {}

ExitanceField::ExitanceField(const BodyView& body, const LitSamples& samples,
                             const ExitanceKernels& kernels, ExitanceAccuracy accuracy,
                             const ExitanceShifts& shifts)
    : accuracy_(accuracy), unit_(kernels.profiles[0].unit()), shifts_(shifts) {
    const ExitanceAccuracy of_terms = accuracy_of_terms(accuracy, kernels);
    std::vector<float> flux(samples.position.size());
    for (std::size_t c = 0; c < 3; ++c) {
        parallel_for(flux.size(), kGrain,
                     [&](std::size_t i) { flux[i] = samples.E_t[i][int(c)] * samples.area[i]; });
        const auto position = [&](std::size_t i) {
            return samples.position[i] +
                   shifts.entry[c] * tangential(samples.w_i[i], samples.normal[i]);
        };
        std::vector<Vec3> moved;
        if (shifts.any()) {
            moved.resize(flux.size());
            parallel_for(flux.size(), kGrain, [&](std::size_t i) { moved[i] = position(i); });
        }
        sums_[c].emplace(SampleSum::Samples{shifts.any() ? moved : samples.position, samples.area,
                                            samples.nodes},
                         flux, kernels.profiles[c], of_terms);
    }
    if (kernels.needs_irradiance()) variate_.emplace(body, samples, kernels, of_terms);
}

Exitance ExitanceField::gather(std::span<const ExitancePoint> points) const {
    Exitance result;
    result.M.resize(points.size());
    result.evaluations.resize(points.size());
    if (points.empty()) return result;
    if (accuracy_.certified) result.bound.resize(points.size());
    std::vector<Vec3> positions(points.size());
    parallel_for(points.size(), kGrain, [&](std::size_t i) { positions[i] = points[i].position; });
    const SumTargets targets(std::move(positions), unit_, accuracy_);
    SampleSum::Result sum;
    for (std::size_t c = 0; c < 3; ++c) {
        if (shifts_.exit[c] != 0) {
            std::vector<Vec3> moved(points.size());
            parallel_for(points.size(), kGrain, [&](std::size_t i) {
                moved[i] =
                    points[i].position - shifts_.exit[c] * tangential(points[i].w_o, points[i].n);
            });
            sums_[c]->evaluate(SumTargets(std::move(moved), unit_, accuracy_), sum);
        } else {
            sums_[c]->evaluate(targets, sum);
        }
        result.repeated += sum.certification.repeated;
        result.uncertified += sum.certification.uncertified;
        parallel_for(points.size(), kGrain, [&](std::size_t i) {
            result.M[i][int(c)] = sum.sum[i];
            result.evaluations[i] += sum.evaluations[i];
            if (accuracy_.certified) result.bound[i][int(c)] = sum.bound[i];
        });
    }
    if (variate_) add_control_variate(points, targets, result);
    parallel_for(points.size(), kGrain, [&](std::size_t i) {
        if (to_body_) {
            const ExitancePoint& at = points[i];
            const Rgb factor = to_body_->factor(at.position, at.n, at.w_o, result.M[i]);
            result.M[i] *= factor;
            if (accuracy_.certified) result.bound[i] *= factor;
        }
        result.M[i] = map(result.M[i], [](float M) { return std::max(M, 0.0f); });
    });
    return result;
}

void ExitanceField::add_control_variate(std::span<const ExitancePoint> points,
                                        const SumTargets& targets, Exitance& result) const {
    std::vector<Rgb> E(points.size());
    parallel_for(points.size(), kGrain, [&](std::size_t i) { E[i] = points[i].E_direct; });
    const ControlVariate::Result variate = variate_->evaluate(targets, E);
    result.uncertified = 0;  // it is the bound of the whole that counts
    for (std::size_t i = 0; i < points.size(); ++i) {
        result.evaluations[i] += variate.evaluations[i];
        for (std::size_t c = 0; c < 3; ++c) {
            result.M[i][int(c)] += variate.C[c][i];
            if (!accuracy_.certified) continue;
            const float M = result.M[i][int(c)];
            float& bound = result.bound[i][int(c)];
            bound += variate.bound[c][i];
            result.uncertified += !(bound <= accuracy_.tolerance * (M - bound));
        }
    }
}

}  // namespace tallow
