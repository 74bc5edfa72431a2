// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/light_balance.h"

#include <algorithm>
#include <cmath>

namespace tallow {

LightBalance::LightBalance(const ReducedChannel& reduced)
    : weight_(std::max(0.0, 1 - 1.5 * std::sqrt(1 - reduced.alpha_prime))),
      alpha_prime_(reduced.alpha_prime) {}

}  // namespace tallow
