// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tallow {

/// One callable out of several lambdas, for std::visit.
template <class... F>
struct Overloaded : F... {
    using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

}  // namespace tallow
