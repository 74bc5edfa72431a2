// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/cloud/cache_format.h"

namespace tallow {

/// One "key=value" line a pair, each ended by '\n'. Keys must be free of '=' and neither part may
/// hold a line break.
std::string encode_fingerprint(const Fingerprint& fingerprint);

/// The inverse of encode_fingerprint(). Nothing if the text was not made by it.
std::optional<Fingerprint> decode_fingerprint(std::string_view text);

/// Lines each ended by '\n'.
std::string encode_lines(const std::vector<std::string>& lines);

/// The inverse of encode_lines(). Nothing if the last line has no end.
std::optional<std::vector<std::string>> decode_lines(std::string_view text);

}  // namespace tallow
