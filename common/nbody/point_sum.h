// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "common/nbody/group_sum.h"
#include "common/nbody/kernel_table.h"
#include "common/nbody/sum_tree.h"
#include "common/nbody/target_groups.h"

namespace tallow {

/// One scalar N-body problem: weighted points under an octree, summed with a radial kernel.
///
///     M(x) = sum over j of w_j K(|x - x_j|^2)
///
/// A colour channel is one such problem with its own weights, positions and kernel; so are the sums
/// of a boundary-element solve. Nodes stand for their points where Taylor's remainder allows it,
/// and groups of neighbouring points share the work. docs/EVALUATOR.md has the method and its
/// bounds.
///
/// Domain   weights >= 0; any kernel that KernelTable can hold. Relative errors are those of sums
///          that do not cancel: for kernels that change their sign they mean little.
class PointSum {
public:
    /// Where results go, one item a target in the order of the positions that the groups were made
    /// of.
    struct Output {
        std::span<float> sum;
        std::span<float> evaluations;  // of the kernel; what a group shares is divided among it
        std::span<float> bound{};      // of the error of sum[]; certify() only
    };
    struct Certification {
        std::size_t repeated = 0;     ///< targets whose group needed more than one round
        std::size_t uncertified = 0;  ///< targets whose bound exceeds what was asked for
    };

    /// positions[] in mm and weights[] in the order that `nodes` refers to.
    PointSum(std::span<const Vec3> positions, std::span<const float> weights,
             std::span<const OctreeNode> nodes, KernelTable kernel);
    /// Sums over the same points, with another kernel of the same unit.
    PointSum(const PointSum& sum, KernelTable kernel);

    /// Sums whose measured relative error stays below `tolerance`, in (0, 1): the root mean square
    /// over all targets, over their mean. Not a bound, and measured for kernels that fall; a kernel
    /// that rises first can miss it by half, one as wide as a few nodes by twice. The same for any
    /// number of threads.
    void evaluate(const TargetGroups& targets, float tolerance, const Output& output) const;

    /// Sums with |sum - M| <= bound <= tolerance * M for each target, M the exact sum with the
    /// exact kernel. Targets where float arithmetic or the kernel's table cannot give that are
    /// counted in the result; their bound holds all the same.
    Certification certify(const TargetGroups& targets, float tolerance, const Output& output) const;

    const KernelTable& kernel() const { return kernel_; }
    const SumTree& tree() const { return *tree_; }
    /// The instruction set to use, for tests and benchmarks; the machine's best otherwise.
    void use(const GroupSumFunctions& functions) { functions_ = functions; }

private:
    struct Plain {
        double sum, bound;
    };
    struct Judgement {
        float excess = 0;
        std::size_t hopeless = 0;
    };
    GroupSumInput input(const TargetGroups& targets, std::size_t group) const;
    std::vector<float> estimate(const TargetGroups& targets) const;
    void put(const TargetGroups& targets, std::size_t group, const GroupSumState& state,
             const Output& output) const;
    Certification certify_group(const TargetGroups& targets, std::size_t group, float estimate,
                                float tolerance, GroupSumState& state, const Output& output) const;
    Judgement judge(const TargetGroups& targets, std::size_t group, float tolerance,
                    const Output& output) const;
    std::size_t sum_plainly(const TargetGroups& targets, std::size_t group, float tolerance,
                            const Output& output) const;
    Plain plain(float x, float y, float z) const;
    double with_table_error(double sum, double bound) const;

    KernelTable kernel_;
    std::shared_ptr<const SumTree> tree_;
    GroupSumFunctions functions_;
    double scale_;  // from the units of the tree to 1/mm^2 and the weights' unit
};

}  // namespace tallow
