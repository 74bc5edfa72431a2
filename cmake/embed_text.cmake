# SPDX-License-Identifier: Apache-2.0
# Script: turns the text file INPUT into the C++ source OUTPUT, which defines
# `const std::string_view tallow::SYMBOL` with the file's content.
#
#   cmake -DINPUT=... -DOUTPUT=... -DSYMBOL=... -P embed_text.cmake
file(READ "${INPUT}" text)
if(text MATCHES "\\)embedded\"")
  message(FATAL_ERROR "${INPUT} holds the delimiter of a raw string")
endif()
file(WRITE "${OUTPUT}" "// Generated from ${INPUT} by embed_text.cmake.
#include <string_view>
namespace tallow {
extern const std::string_view ${SYMBOL};
const std::string_view ${SYMBOL} = R\"embedded(${text})embedded\";
}  // namespace tallow
")
