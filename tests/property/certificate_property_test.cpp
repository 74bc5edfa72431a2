// SPDX-License-Identifier: Apache-2.0
// What PointSum::certify promises, on random problems: for every target the sum differs from the
// exact one, taken in double with the kernel itself and not with its table, by no more than the
// bound; and the bound is within the tolerance or counted as being not.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "common/nbody/point_sum.h"
#include "tests/property/intensity.h"
#include "tests/property/random_sums.h"

namespace tallow {
namespace {

using test::DirectSum;
using test::Draw;
using test::RandomCloud;
using test::RandomKernel;

// Some 3 to 4 s on one core, all instruction sets included.
constexpr std::uint64_t kProblems = 90;
constexpr float kTolerances[] = {0.1f, 0.01f, 0.001f, 1e-4f};
// Sums in double have rounding errors of their own.
constexpr double kReferenceError = 1e-13;

/// One sum at many points, and what it should be.
struct Problem {
    std::string name;
    RandomCloud points;
    std::vector<Vec3> targets;
    KernelTable table;
    float tolerance;
    std::vector<DirectSum> exact;

    PointSum point_sum() const {
        return {points.cloud.positions, points.cloud.weights, points.cloud.nodes, table};
    }
};

struct Result {
    std::vector<float> sum, evaluations, bound;
    PointSum::Certification certification;

    Result(const PointSum& sums, const Problem& problem)
        : sum(problem.targets.size()), evaluations(sum.size()), bound(sum.size()) {
        const TargetGroups targets(problem.targets, problem.table.unit());
        certification = sums.certify(targets, problem.tolerance, {sum, evaluations, bound});
    }
};

struct Statistics {
    std::size_t checked = 0, repeated = 0, uncertified = 0;
    double worst = 0;    // largest error / bound
    double typical = 0;  // their sum

    void print(const char* what) const {
        std::cout << fmt::format(
            "{}: {} sums checked, {} repeated, {} uncertified; |error| / bound at most {:.3f}, "
            "{:.4f} "
            "on average\n",
            what, checked, repeated, uncertified, worst, typical / double(checked));
    }
};

// Few samples often, many now and then; targets so that the exact sums stay affordable.
Problem draw_problem(std::uint64_t seed) {
    Draw draw(seed);
    const double size = draw.log_uniform(1e-3, 1e3);
    const RandomKernel kernel = test::draw_kernel(draw, size);
    const auto samples = std::size_t(draw.log_uniform(1, 6000));
    const std::size_t targets = std::clamp<std::size_t>(250000 / samples, 1, 2000);
    RandomCloud points = test::draw_cloud(draw, size, samples);
    // A unit that suits another channel's kernel better.
    const double factor = draw.one_in(3) ? draw.log_uniform(0.1, 10) : 1;
    KernelTable table = kernel.table(KernelTable::unit_near(kernel.scale * factor));
    auto at = test::draw_targets(draw, points, std::sqrt(table.range()), targets);
    const float tolerance = kTolerances[draw.below(4)];
    auto exact = test::direct_sums(points.cloud, at, kernel.exact);
    std::string name = fmt::format("seed {}: {}, mean free path {}; {}; tolerance {}", seed,
                                   kernel.name, kernel.scale, points.name, tolerance);
    return {name, std::move(points), std::move(at), std::move(table), tolerance, std::move(exact)};
}

// The worst violation says more than the first. Targets whose bound is too large must have been
// counted; sums just on the limit may or may not be.
void check(const Problem& problem, const Result& result, Statistics& statistics) {
    std::size_t too_large = 0, surely = 0, possibly = 0, worst_target = 0, not_finite = 0;
    double worst = 0;
    for (std::size_t i = 0; i < result.sum.size(); ++i) {
        const double sum = result.sum[i], bound = result.bound[i], M = problem.exact[i].sum;
        const double tolerance = problem.tolerance;
        const double error = std::max(0.0, std::abs(sum - M) - kReferenceError * M);
        not_finite += !std::isfinite(sum) || !std::isfinite(bound) || bound < 0 ||
                      !std::isfinite(result.evaluations[i]);
        const double ratio = error > 0 ? error / bound : 0;
        if (!(ratio <= worst)) worst = ratio, worst_target = i;
        statistics.typical += ratio;
        too_large += bound > tolerance * M * (1 + kReferenceError);
        // What certify() compares, give or take the rounding of its results to float.
        const double rounding = 1e-5 * bound + 2e-7 * sum;
        surely += bound - rounding > tolerance * (sum - bound + rounding);
        possibly += bound + rounding > tolerance * (sum - bound - rounding);
    }
    EXPECT_LE(worst, 1) << problem.name << "; target " << worst_target << " of "
                        << result.sum.size() << ": sum " << result.sum[worst_target] << " exact "
                        << problem.exact[worst_target].sum << " bound "
                        << result.bound[worst_target] << " evaluations "
                        << result.evaluations[worst_target];
    EXPECT_EQ(not_finite, 0u) << problem.name;
    const std::size_t uncertified = result.certification.uncertified;
    EXPECT_LE(too_large, uncertified) << problem.name;
    EXPECT_TRUE(surely <= uncertified && uncertified <= possibly)
        << problem.name << ": " << surely << ' ' << uncertified << ' ' << possibly;
    EXPECT_LE(result.certification.repeated, result.sum.size());
    statistics.checked += result.sum.size();
    statistics.repeated += result.certification.repeated;
    statistics.uncertified += uncertified;
    statistics.worst = std::max(statistics.worst, worst);
}

// The first problems run on all instruction sets, the many that TALLOW_TEST_INTENSITY asks for on
// this machine's best.
TEST(Certificate, HoldsOnRandomProblems) {
    const auto problems = std::uint64_t(std::ceil(double(kProblems) * test::intensity()));
    const std::vector<GroupSumFunctions> all = all_group_sum_functions();
    std::vector<Statistics> statistics(all.size());
    for (std::uint64_t seed = 0; seed < problems && !HasFailure(); ++seed) {
        const Problem problem = draw_problem(seed);
        PointSum sums = problem.point_sum();
        for (std::size_t f = 0; f < (seed < kProblems ? all.size() : 1); ++f) {
            SCOPED_TRACE(all[f].name);
            sums.use(all[f]);
            check(problem, Result(sums, problem), statistics[f]);
        }
    }
    for (std::size_t f = 0; f < all.size(); ++f) statistics[f].print(all[f].name);
    RecordProperty("checked", fmt::format("{}", statistics[0].checked));
    RecordProperty("worst", fmt::format("{}", statistics[0].worst));
}

}  // namespace
}  // namespace tallow
