// SPDX-License-Identifier: Apache-2.0
#include "experiments/evaluator/measure.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <numeric>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "common/exitance/exitance_field.h"
#include "common/optics/dipole.h"

namespace tallow {
namespace {

// The best of several runs leaves out what else the machine did; runs so long need no second one.
constexpr double kLongEnough = 10;  // s, all runs together

struct Time {
    double wall, cpu;  // s, of the same run; cpu of all threads together
};

template <class Run>
Time best_time(int repeat, const Run& run, std::vector<double>* walls = nullptr) {
    Time best{1e30, 0};
    double all = 0;
    for (int i = 0; i < repeat && (i == 0 || all < kLongEnough); ++i) {
        const std::clock_t cpu_start = std::clock();
        const auto start = std::chrono::steady_clock::now();
        run();
        const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
        const double cpu = double(std::clock() - cpu_start) / CLOCKS_PER_SEC;
        if (wall.count() < best.wall) best = {wall.count(), cpu};
        all += wall.count();
        if (walls) walls->push_back(wall.count());
    }
    return best;
}

// Runs the evaluation of a measurement.
template <class Run>
void time_evaluation(Measurement& m, int repeat, const Run& run) {
    const Time time = best_time(repeat, run, &m.runs);
    m.evaluation = time.wall, m.busy = time.cpu / time.wall;
}

std::array<KernelTable, 3> tabulate(const Problem& problem) {
    return tabulate_profiles(problem.kind.model, problem.kind.medium, problem.orders);
}

double mean_of(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

class ErrorMethod : public Method {
public:
    ErrorMethod(const Problem& problem, bool certified, int repeat)
        : problem_(problem), certified_(certified) {
        isa = group_sum_functions().name;
        const std::array<KernelTable, 3> tables = tabulate(problem);
        preparation_ =
            best_time(repeat, [&] {
                for (std::size_t c = 0; c < 3; ++c)
                    sums_[c] = std::make_unique<PointSum>(problem.samples.position, problem.flux[c],
                                                          problem.samples.nodes, tables[c]);
            }).wall;
    }

    Measurement measure(double tolerance, int repeat) const override {
        const std::size_t n = problem_.points.size();
        const double unit = sums_[0]->kernel().unit();
        Measurement m;
        m.grouping =
            best_time(repeat, [&] { const TargetGroups targets(problem_.points, unit); }).wall;
        const TargetGroups targets(problem_.points, unit);
        std::array<std::vector<float>, 3> evaluations;
        for (std::size_t c = 0; c < 3; ++c) {
            m.M[c].resize(n), evaluations[c].resize(n);
            if (certified_) m.bound[c].resize(n);
        }
        time_evaluation(m, repeat, [&] {
            m.repeated = m.uncertified = 0;
            for (std::size_t c = 0; c < 3; ++c) {
                const PointSum::Output output{m.M[c], evaluations[c], m.bound[c]};
                if (certified_) {
                    const auto result = sums_[c]->certify(targets, float(tolerance), output);
                    m.repeated += result.repeated, m.uncertified += result.uncertified;
                } else {
                    sums_[c]->evaluate(targets, float(tolerance), output);
                }
            }
        });
        for (const std::vector<float>& counts : evaluations) m.evaluations += mean_of(counts);
        return m;
    }

private:
    const Problem& problem_;
    bool certified_;
    std::array<std::unique_ptr<PointSum>, 3> sums_;
};

/// One kernel a channel: float(float r2).
template <class Kernel>
class SolidAngleMethod : public Method {
public:
    SolidAngleMethod(const Problem& problem, std::array<Kernel, 3> kernels, int repeat)
        : problem_(problem), kernels_(std::move(kernels)) {
        preparation_ = best_time(repeat, [&] {
                           for (std::size_t c = 0; c < 3; ++c)
                               sums_[c] = std::make_unique<SolidAngleSum>(
                                   problem.samples.position, problem.flux[c], problem.samples.area,
                                   problem.samples.nodes);
                       }).wall;
    }

    Measurement measure(double solid_angle, int repeat) const override {
        const std::size_t n = problem_.points.size();
        Measurement m;
        for (std::vector<float>& M : m.M) M.resize(n);
        std::vector<float> evaluations(n);
        time_evaluation(m, repeat, [&] {
            parallel_for(n, 64, [&](std::size_t i) {  // as ExitanceField does
                std::uint64_t calls = 0;
                for (std::size_t c = 0; c < 3; ++c)
                    m.M[c][i] = float(sums_[c]->evaluate(problem_.points[i], float(solid_angle),
                                                         kernels_[c], calls));
                evaluations[i] = float(calls);
            });
        });
        m.evaluations = mean_of(evaluations);
        return m;
    }

private:
    const Problem& problem_;
    std::array<Kernel, 3> kernels_;
    std::array<std::unique_ptr<SolidAngleSum>, 3> sums_;
};

struct DipoleFormula {
    DipoleChannel<float> channel;
    float operator()(float r2) const { return diffuse_reflectance(channel, r2); }
};

std::array<DipoleFormula, 3> dipole_formulas(const Problem& problem) {
    const Medium& medium = problem.kind.medium;
    const bool classic = problem.kind.model == Model::classic_dipole;
    if (!classic && problem.kind.model != Model::dipole)
        throw UsageError(
            "--criterion: formula needs model: dipole or classic-dipole in the scene; the others "
            "have no formula to evaluate at each node");
    const double A = classic ? classic_mismatch_A(medium.eta) : mismatch_A(medium.eta);
    const auto formula = [&](int c) { return DipoleFormula{dipole_channel<float>(medium, c, A)}; };
    return {formula(0), formula(1), formula(2)};
}

}  // namespace

std::unique_ptr<Method> make_error_method(const Problem& problem, bool certified, int repeat) {
    return std::make_unique<ErrorMethod>(problem, certified, repeat);
}

std::unique_ptr<Method> make_solid_angle_method(const Problem& problem, bool formula, int repeat) {
    if (!formula)
        return std::make_unique<SolidAngleMethod<KernelTable>>(problem, tabulate(problem), repeat);
    auto method = std::make_unique<SolidAngleMethod<DipoleFormula>>(
        problem, dipole_formulas(problem), repeat);
    method->kernel = "formula in float at each node";
    return method;
}

}  // namespace tallow
