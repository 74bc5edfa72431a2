// SPDX-License-Identifier: Apache-2.0
#include "common/base/read_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "common/base/errors.h"

namespace tallow {

std::string read_file(const std::filesystem::path& file, const char* what) {
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (status.type() == std::filesystem::file_type::not_found)
        throw InputError(file.string() + ": no such file");
    if (!std::filesystem::is_regular_file(status))
        throw InputError(file.string() + ": expected a file, got a directory or device");
    std::string bytes(std::filesystem::file_size(file, error), '\0');
    std::ifstream stream(file, std::ios::binary);
    if (!stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
        throw InputError(fmt::format("{}: cannot read: {}", file.string(), std::strerror(errno)));
    if (bytes.empty())
        throw InputError(fmt::format("{}: expected {}, got an empty file", file.string(), what));
    return bytes;
}

}  // namespace tallow
