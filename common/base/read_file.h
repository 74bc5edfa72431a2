// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace tallow {

/// All bytes of a file. Throws InputError naming it for one that is missing, empty, or no file;
/// `what` ("a mesh") tells users what was expected instead of an empty one.
std::string read_file(const std::filesystem::path& file, const char* what);

}  // namespace tallow
