// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

namespace tallow::test {

/// How many times as many random problems as usual to try: TALLOW_TEST_INTENSITY.
inline double intensity() {
    const char* text = std::getenv("TALLOW_TEST_INTENSITY");
    return text ? std::strtod(text, nullptr) : 1;
}

}  // namespace tallow::test
