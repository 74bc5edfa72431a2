// SPDX-License-Identifier: Apache-2.0
// The sums of boundary_sum-inl.h for every instruction set that Highway knows for this
// architecture, and the choice among them at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "common/diffusion/boundary_sum.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

#include "common/diffusion/boundary_sum-inl.h"

#if HWY_ONCE

namespace tallow {

HWY_EXPORT(boundary_functions);

const BoundarySumFunctions& boundary_sum_functions() {
    static const BoundarySumFunctions best = HWY_DYNAMIC_DISPATCH(boundary_functions)();
    return best;
}

}  // namespace tallow
#endif
