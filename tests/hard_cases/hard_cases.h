// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace tallow::test {

/// Holds a hard case to its bound and puts it into the table of docs/NUMERICS.md.
///
/// `reference` says where the expected value comes from; `error` is measured, `bound` is stated. A
/// NaN exceeds every bound.
void expect_within(const std::string& name, const std::string& reference, double error,
                   double bound);

}  // namespace tallow::test
