// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace tallow {

/// Wrong flags or arguments. Exit code 2.
struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Wrong content of a scene, mesh or cache: "file:line:column: key: expected X, got Y", lower
/// case, then what to do about it if we know. Exit code 3.
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// An output cannot be written. Exit code 4.
struct OutputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The user pressed Ctrl-C. Exit code 130.
struct Interrupted : std::runtime_error {
    Interrupted() : std::runtime_error("interrupted") {}
};

}  // namespace tallow
