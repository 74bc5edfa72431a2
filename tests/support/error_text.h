// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace tallow {

/// Message of the Error that `call` throws, or "" if it returns. Other exceptions pass through and
/// fail the test by their own name.
template <class Error, class Call>
std::string error_text(Call&& call) {
    try {
        call();
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

}  // namespace tallow
