// SPDX-License-Identifier: Apache-2.0
// The sum of once_sum-inl.h for every instruction set that Highway knows for this architecture, and
// the choice among them at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "common/diffusion/once_sum.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

#include "common/diffusion/once_sum-inl.h"

#if HWY_ONCE

namespace tallow {

HWY_EXPORT(once_function);

OnceSum once_sum() {
    static const OnceSum best = HWY_DYNAMIC_DISPATCH(once_function)();
    return best;
}

}  // namespace tallow
#endif
