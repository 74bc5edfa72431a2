// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace tallow {

/// A file that appears under its name only when it is whole: bytes go to `name.tmp`, commit()
/// syncs and renames. Without commit() the temporary is removed and an old file stays as it was.
/// All functions throw OutputError with the file's name and the system's reason.
class OutputFile {
public:
    explicit OutputFile(std::filesystem::path file);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    void write(std::span<const std::byte> bytes);
    void write(std::string_view text);
    void commit();

    /// For libraries that write by name: where to write. Close it before commit().
    const std::filesystem::path& temporary() const { return temporary_; }

private:
    std::filesystem::path file_, temporary_;
    int descriptor_ = -1;
};

/// Whether a file can appear under this name, asked before the work whose result it shall hold:
/// its folder exists and takes new files, and it is no folder itself. What only writing can tell (a
/// full disk) remains to be told then. Throws OutputError as OutputFile does.
void require_writable(const std::filesystem::path& file);

}  // namespace tallow
