// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <stdexcept>

/// States an invariant of ours; stays on in release builds. A failure is our bug (exit code 1),
/// never a user's error, and throws so that a parallel loop can carry it to the main thread.
/// The further arguments are a fmt string with the values that were compared.
#define TALLOW_CHECK(condition, ...)                                                              \
    do {                                                                                          \
        if (!(condition))                                                                         \
            throw std::logic_error(fmt::format("{}:{}: {} does not hold: {}", __FILE__, __LINE__, \
                                               #condition, fmt::format(__VA_ARGS__)));            \
    } while (false)

/// The same for inner loops: compiled in only with TALLOW_DCHECK_ON (presets debug, asan, tsan).
#ifdef TALLOW_DCHECK_ON
#define TALLOW_DCHECK(condition, ...) TALLOW_CHECK(condition, __VA_ARGS__)
#else
#define TALLOW_DCHECK(condition, ...) \
    do {                              \
    } while (false)
#endif
