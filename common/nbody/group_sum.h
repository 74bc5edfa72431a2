// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/nbody/kernel_table.h"
#include "common/nbody/sum_tree.h"
#include "common/nbody/target_groups.h"

namespace tallow {

/// What the sums of one group need; all in the units of the tree.
struct GroupSumInput {
    const SumTree::Block* blocks;
    const SumTree::Point* points;
    KernelTable::View kernel;
    const TargetGroups::Packet* packets;  // those of the group
    TargetGroups::Group group;
};

/// Results of one group, and the lists that are reused from group to group.
struct GroupSumState {
    struct PacketResult {
        alignas(64) float sum[TargetGroups::kPacketSize];
        float bound;                // of the error of each sum; certified sums only
        std::uint32_t evaluations;  // of the kernel, for each point
    };
    struct Node {
        std::uint32_t block, lanes;  // bit mask of children
    };
    std::vector<PacketResult> packets;
    std::uint32_t group_evaluations;  // made once for all points of the group

    std::vector<Node> near;                           // left over by the group for its packets
    std::vector<std::uint32_t> queue, nodes, leaves;  // of blocks; of block * 8 + lane
    std::vector<float> near_points, near_nodes;       // columns of those, one after the other
};

/// Largest remainders (docs/EVALUATOR.md) that single nodes may have: those whose ball is apart
/// from that of the points, and those that overlap it. The remainder of the latter is a tight
/// bound; that of the others overstates the error 10 to 100 times.
struct NodeThresholds {
    float apart, overlapping;
};

/// One instruction set's version of the sums over a tree. docs/EVALUATOR.md explains what they do.
struct GroupSumFunctions {
    const char* name;
    /// The sum at the group's center, within a factor of about 2, from few nodes.
    float (*estimate)(const GroupSumInput& input, GroupSumState& state);
    /// The sums at all points of the group. A node stands for its points where the bound of its
    /// remainder is below the threshold.
    void (*sum)(const GroupSumInput& input, NodeThresholds thresholds, GroupSumState& state);
    /// The same with PacketResult::bound.
    void (*certified_sum)(const GroupSumInput& input, float threshold, GroupSumState& state);
};

/// The version for this machine's best instruction set.
const GroupSumFunctions& group_sum_functions();
/// All versions that this machine can run, best first; the last is scalar code.
std::vector<GroupSumFunctions> all_group_sum_functions();

}  // namespace tallow
