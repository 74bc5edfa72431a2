// SPDX-License-Identifier: Apache-2.0
// The bounds of GroupSumFunctions::certified_sum against the table itself, in double: remainders
// and rounding alone, which in PointSum::certify the table's error mostly hides.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "common/nbody/group_sum.h"
#include "tests/property/exact_table.h"
#include "tests/property/intensity.h"
#include "tests/property/random_sums.h"

namespace tallow {
namespace {

using test::Draw;
using test::ExactTable;

constexpr std::uint64_t kProblems = 250;  // about a second, all instruction sets included

double exact_sum(const SumTree& tree, const ExactTable& kernel, const DVec3& x) {
    double sum = 0;
    for (const SumTree::Point& p : tree.points()) {
        const DVec3 d = x - DVec3(p.x, p.y, p.z);
        sum += double(p.weight) * kernel(glm::dot(d, d));
    }
    return sum;
}

struct Problem {
    std::string name;
    KernelTable table;
    SumTree tree;
    TargetGroups targets;
    std::vector<double> exact;  // in the groups' order, each packet filled up with its last point
    // Where the table fades out, near its end, its cubics cancel and their rounding errors are far
    // above their values. What certify() adds for the table covers that.
    double negligible;
    float rough;  // a node may have a remainder of so much of its group's sum
};

Problem draw_problem(std::uint64_t seed) {
    Draw draw(seed);
    const double size = draw.log_uniform(0.1, 10);
    const test::RandomKernel kernel = test::draw_kernel(draw, size);
    const auto samples = std::size_t(draw.log_uniform(1, 2000));
    const std::size_t at_most = draw.one_in(2) ? TargetGroups::kPacketSize : 600;
    const test::RandomCloud points = test::draw_cloud(draw, size, samples);
    KernelTable table = kernel.table(KernelTable::unit_near(kernel.scale));
    const auto at = test::draw_targets(draw, points, std::sqrt(table.range()),
                                       std::min<std::size_t>(at_most, 100000 / samples + 1));
    const double rough = draw.log_uniform(1e-7, 1);
    SumTree tree(points.cloud.positions, points.cloud.weights, points.cloud.nodes, table.unit());
    TargetGroups targets(at, table.unit());
    std::vector<double> exact(targets.packets().size() * TargetGroups::kPacketSize);
    const ExactTable exact_table(table.view());
    parallel_for(exact.size(), 16, [&](std::size_t k) {
        const auto& packet = targets.packets()[k / TargetGroups::kPacketSize];
        const std::size_t i = k % TargetGroups::kPacketSize;
        if (i < packet.count)
            exact[k] = exact_sum(tree, exact_table, DVec3(packet.x[i], packet.y[i], packet.z[i]));
    });
    const double negligible = table.max_error_beyond() * table.unit() * table.unit() *
                              tree.total_weight() / tree.weight_scale();
    return {fmt::format("seed {}: {}, scale {}; {}; threshold {}", seed, kernel.name, kernel.scale,
                        points.name, rough),
            std::move(table),
            std::move(tree),
            std::move(targets),
            std::move(exact),
            negligible,
            float(rough)};
}

struct Statistics {
    std::size_t checked = 0;
    double worst = 0;
};

void check_group(const Problem& problem, const GroupSumFunctions& functions,
                 const TargetGroups::Group& group, Statistics& statistics) {
    const GroupSumInput input{problem.tree.blocks().data(), problem.tree.points().data(),
                              problem.table.view(),
                              problem.targets.packets().data() + group.first_packet, group};
    GroupSumState state;
    const float estimate = functions.estimate(input, state);
    functions.certified_sum(input, problem.rough * estimate, state);
    for (std::uint32_t p = 0; p < group.packets; ++p)
        for (std::uint32_t i = 0; i < input.packets[p].count; ++i) {
            const double exact =
                problem.exact[(group.first_packet + p) * TargetGroups::kPacketSize + i];
            const double sum = state.packets[p].sum[i], bound = state.packets[p].bound;
            const double error =
                std::max(0.0, std::abs(sum - exact) - 1e-13 * std::abs(exact) - problem.negligible);
            ASSERT_TRUE(std::isfinite(sum) && std::isfinite(bound) && error <= bound)
                << problem.name << ": sum " << sum << " exact " << exact << " bound " << bound;
            if (error > 0) statistics.worst = std::max(statistics.worst, error / bound);
            ++statistics.checked;
        }
}

TEST(GroupBound, HoldsForTheTableItself) {
    const auto problems = std::uint64_t(std::ceil(double(kProblems) * test::intensity()));
    const std::vector<GroupSumFunctions> all = all_group_sum_functions();
    Statistics statistics;
    for (std::uint64_t seed = 0; seed < problems && !HasFailure(); ++seed) {
        const Problem problem = draw_problem(seed);
        for (std::size_t f = 0; f < (seed < kProblems ? all.size() : 1); ++f) {
            SCOPED_TRACE(all[f].name);
            for (const TargetGroups::Group& group : problem.targets.groups())
                check_group(problem, all[f], group, statistics);
        }
    }
    std::cout << fmt::format("{} sums checked; |error| / bound at most {:.3f}\n",
                             statistics.checked, statistics.worst);
}

}  // namespace
}  // namespace tallow
