// SPDX-License-Identifier: Apache-2.0
// The sums of group_sum-inl.h for every instruction set that Highway knows for this architecture,
// and the choice among them at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "common/nbody/group_sum.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

#include "common/nbody/group_sum-inl.h"

#if HWY_ONCE

namespace tallow {

HWY_EXPORT(functions);

const GroupSumFunctions& group_sum_functions() {
    static const GroupSumFunctions best = HWY_DYNAMIC_DISPATCH(functions)();
    return best;
}

std::vector<GroupSumFunctions> all_group_sum_functions() {
    std::vector<GroupSumFunctions> all;
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        all.push_back(HWY_DYNAMIC_DISPATCH(functions)());
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return all;
}

}  // namespace tallow
#endif
