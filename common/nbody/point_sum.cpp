// SPDX-License-Identifier: Apache-2.0
// Thresholds for the sums of group_sum: from a rough estimate of each group's sums, a tolerance
// becomes the largest remainder that a single node may have; afterwards the result is checked
// against what was assumed, and the group is summed again where that was wrong.
#include "common/nbody/point_sum.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "common/base/check.h"
#include "common/base/parallel.h"

namespace tallow {
namespace {

constexpr std::size_t kGrain = 4;  // groups

// Nodes may have a remainder of so much of the group's sum. Remainders are bounds, and errors of
// different nodes cancel: measured relRMSE is 0.2 to 0.83 of the tolerance over three decades
// (docs/EVALUATOR.md has the table and the command that made it). At loose tolerances few nodes
// that overlap the points make most of the error, so the others may have more.
NodeThresholds thresholds_for(float tolerance) {
    const float overlapping = 10.5f * std::pow(tolerance, 1.4f);
    const float more = std::clamp(8 * std::pow(tolerance / 0.01f, 0.9f), 1.0f, 8.0f);
    return {more * overlapping, overlapping};
}

NodeThresholds operator*(float sum, const NodeThresholds& t) {
    return {sum * t.apart, sum * t.overlapping};
}

// The same for certificates, where remainders add up. Fitted so that few groups need a second round
// on the bunny in marble (column repeated_share of docs/results/evaluator.csv).
float certified_threshold_for(float tolerance) { return 0.008f * std::pow(tolerance, 1.5f); }

// A group's sums may be so much less than estimated before it is summed again.
constexpr float kOverestimated = 2;

// Sums below this part of the mean over all groups need not be exact to the tolerance: no metric or
// eye would see it, and exponentially dark points would otherwise cost the most.
constexpr float kDark = 1e-3f;

constexpr int kRounds = 4;
constexpr double kTableMargin = 1.5;  // the table's error is measured at places, not everywhere

}  // namespace

PointSum::PointSum(std::span<const Vec3> positions, std::span<const float> weights,
                   std::span<const OctreeNode> nodes, KernelTable kernel)
    : kernel_(std::move(kernel)),
      tree_(std::make_shared<SumTree>(positions, weights, nodes, kernel_.unit())),
      functions_(group_sum_functions()),
      scale_(tree_->weight_scale() / (kernel_.unit() * kernel_.unit())) {}

PointSum::PointSum(const PointSum& sum, KernelTable kernel)
    : kernel_(std::move(kernel)), tree_(sum.tree_), functions_(sum.functions_), scale_(sum.scale_) {
    TALLOW_CHECK(kernel_.unit() == sum.kernel_.unit(), "units {} and {}", kernel_.unit(),
                 sum.kernel_.unit());
}

GroupSumInput PointSum::input(const TargetGroups& targets, std::size_t group) const {
    const TargetGroups::Group& g = targets.groups()[group];
    return {tree_->blocks().data(), tree_->points().data(), kernel_.view(),
            targets.packets().data() + g.first_packet, g};
}

std::vector<float> PointSum::estimate(const TargetGroups& targets) const {
    std::vector<float> estimates(targets.groups().size());
    parallel_ranges(estimates.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        GroupSumState state;
        for (std::size_t g = begin; g < end; ++g)
            estimates[g] = std::abs(functions_.estimate(input(targets, g), state));
    });
    return estimates;
}

void PointSum::put(const TargetGroups& targets, std::size_t group, const GroupSumState& state,
                   const Output& output) const {
    const GroupSumInput in = input(targets, group);
    const float shared = float(state.group_evaluations) / float(in.group.points);
    for (std::uint32_t p = 0; p < in.group.packets; ++p) {
        const TargetGroups::Packet& packet = in.packets[p];
        for (std::uint32_t i = 0; i < packet.count; ++i) {
            const std::uint32_t target = targets.order()[packet.first + i];
            output.sum[target] = float(scale_ * state.packets[p].sum[i]);
            output.evaluations[target] = shared + float(state.packets[p].evaluations);
            if (!output.bound.empty())
                output.bound[target] = float(with_table_error(scale_ * state.packets[p].sum[i],
                                                              scale_ * state.packets[p].bound));
        }
    }
}

void PointSum::evaluate(const TargetGroups& targets, float tolerance, const Output& output) const {
    TALLOW_CHECK(targets.unit() == kernel_.unit(), "units {} and {}", targets.unit(),
                 kernel_.unit());
    if (tree_->blocks().empty()) {
        std::fill(output.sum.begin(), output.sum.end(), 0.0f);
        std::fill(output.evaluations.begin(), output.evaluations.end(), 0.0f);
        return;
    }
    const std::vector<float> estimates = estimate(targets);
    double mean = 0;
    for (std::size_t g = 0; g < estimates.size(); ++g)
        mean += double(estimates[g]) * targets.groups()[g].points / double(targets.order().size());
    const float least = kDark * float(mean);
    const NodeThresholds thresholds = thresholds_for(tolerance);
    parallel_ranges(estimates.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        GroupSumState state;
        for (std::size_t g = begin; g < end; ++g) {
            const GroupSumInput in = input(targets, g);
            const float assumed = std::max(estimates[g], least);
            functions_.sum(in, assumed * thresholds, state);
            float smallest = kInfinity;
            for (std::uint32_t p = 0; p < in.group.packets; ++p)
                for (const float sum : state.packets[p].sum)
                    smallest = std::min(smallest, std::abs(sum));
            smallest = std::max(smallest, least);
            if (assumed > kOverestimated * smallest)
                functions_.sum(in, smallest * thresholds, state);
            put(targets, g, state, output);
        }
    });
}

// The kernel in double differs from the table's by at most its stated error. Also covers rounding
// the sum and the bound to float.
double PointSum::with_table_error(double sum, double bound) const {
    const double table = kernel_.max_relative_error() * (std::abs(sum) + bound) +
                         kernel_.max_error_beyond() * tree_->total_weight();
    return (1 + 0x1p-22) * (bound + kTableMargin * table + 0x1p-23 * std::abs(sum));
}

PointSum::Certification PointSum::certify(const TargetGroups& targets, float tolerance,
                                          const Output& output) const {
    TALLOW_CHECK(targets.unit() == kernel_.unit(), "units {} and {}", targets.unit(),
                 kernel_.unit());
    TALLOW_CHECK(output.bound.size() == output.sum.size(), "{} bounds", output.bound.size());
    if (tree_->blocks().empty()) {
        for (const std::span<float> values : {output.sum, output.evaluations, output.bound})
            std::fill(values.begin(), values.end(), 0.0f);
        return {};
    }
    const std::vector<float> estimates = estimate(targets);
    std::atomic<std::size_t> repeated{0}, uncertified{0};
    parallel_ranges(estimates.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        GroupSumState state;
        for (std::size_t g = begin; g < end; ++g) {
            const Certification of_group =
                certify_group(targets, g, estimates[g], tolerance, state, output);
            repeated += of_group.repeated, uncertified += of_group.uncertified;
        }
    });
    return {repeated, uncertified};
}

// The largest of bound / (what it may be) over a group, and how many points are too dark for any
// bound: the table's error alone is more than they may have. A bound may be tolerance * (sum -
// bound), which is at most tolerance times the exact sum.
PointSum::Judgement PointSum::judge(const TargetGroups& targets, std::size_t group, float tolerance,
                                    const Output& output) const {
    const GroupSumInput in = input(targets, group);
    const std::uint32_t first = in.packets[0].first;
    Judgement result;
    for (std::uint32_t k = first; k < first + in.group.points; ++k) {
        const std::uint32_t target = targets.order()[k];
        const float sum = output.sum[target], bound = output.bound[target];
        const float allowed = tolerance * (sum - bound);
        if (bound <= allowed) continue;
        if (with_table_error(sum, 0) > tolerance * sum)
            result.hopeless += 1;
        else
            result.excess = std::max(result.excess, allowed > 0 ? bound / allowed : kInfinity);
    }
    return result;
}

PointSum::Certification PointSum::certify_group(const TargetGroups& targets, std::size_t group,
                                                float estimate, float tolerance,
                                                GroupSumState& state, const Output& output) const {
    const GroupSumInput in = input(targets, group);
    float threshold = certified_threshold_for(tolerance) * estimate;
    for (int round = 0; round < kRounds; ++round) {
        functions_.certified_sum(in, threshold, state);
        put(targets, group, state, output);
        const Judgement judgement = judge(targets, group, tolerance, output);
        if (judgement.excess <= 1) return {round > 0 ? in.group.points : 0u, judgement.hopeless};
        // Bounds grow as the threshold to the power of 2/3; a little more than that would ask for.
        threshold *= std::clamp(0.8f * std::pow(judgement.excess, -1.5f), 1e-3f, 0.5f);
    }
    return {in.group.points, sum_plainly(targets, group, tolerance, output)};
}

// Returns how many bounds are too large even so.
std::size_t PointSum::sum_plainly(const TargetGroups& targets, std::size_t group, float tolerance,
                                  const Output& output) const {
    const GroupSumInput in = input(targets, group);
    std::size_t uncertified = 0;
    for (std::uint32_t p = 0; p < in.group.packets; ++p) {
        const TargetGroups::Packet& packet = in.packets[p];
        for (std::uint32_t i = 0; i < packet.count; ++i) {
            const std::uint32_t target = targets.order()[packet.first + i];
            const Plain result = plain(packet.x[i], packet.y[i], packet.z[i]);
            const double bound = with_table_error(result.sum, result.bound);
            output.sum[target] = float(result.sum);
            output.evaluations[target] = float(tree_->points().size());
            output.bound[target] = float(bound);
            uncertified +=
                !(output.bound[target] <= tolerance * (output.sum[target] - output.bound[target]));
        }
    }
    return uncertified;
}

// Every point, accumulated in double. The kernel's own rounding as for points in group_sum-inl.h.
PointSum::Plain PointSum::plain(float x, float y, float z) const {
    const float offset = kernel_.view().offset;
    double sum = 0, rounding = 0;
    for (const SumTree::Point& p : tree_->points()) {
        const float dx = x - p.x, dy = y - p.y, dz = z - p.z;
        const float u = dx * dx + dy * dy + dz * dz, v = u + offset;
        const auto [s, t] = kernel_.place(u);
        const float k0 = s.c0 + t * (s.c1 + t * (s.c2 + t * s.c3));
        const double c1 = std::abs(s.c1), c2 = std::abs(s.c2), c3 = std::abs(s.c3);
        const double terms = std::abs(s.c0) + t * (c1 + t * (c2 + t * c3));
        const double slope = c1 + t * (2 * c2 + t * 3 * c3);
        sum += double(p.weight) * k0;
        rounding += double(p.weight) * (10 * terms + 7 * v * slope);
    }
    return {scale_ * sum, scale_ * 0x1p-24 * 1.001 * rounding};
}

}  // namespace tallow
