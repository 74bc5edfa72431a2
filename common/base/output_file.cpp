// SPDX-License-Identifier: Apache-2.0
// Atomic output over POSIX calls: the C++ streams know neither fsync nor the reason of a failure.
#include "common/base/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "common/base/errors.h"

namespace tallow {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const char* what) {
    const int reason = errno;
    throw OutputError(fmt::format("{}: {}: {}", file.string(), what, std::strerror(reason)));
}

/// A device or a pipe (/dev/stdout) can not be replaced by renaming; it is written in place.
bool is_special(const std::filesystem::path& file) {
    struct stat status {};
    return ::stat(file.c_str(), &status) == 0 && !S_ISREG(status.st_mode);
}

/// Where a symbolic link leads, so that the rename replaces the file and not the link.
std::filesystem::path resolve_link(const std::filesystem::path& file) {
    std::error_code error;
    if (!std::filesystem::is_symlink(file, error)) return file;
    const auto target = std::filesystem::canonical(file, error);
    return error ? file : target;
}

std::filesystem::path temporary_of(std::filesystem::path file) { return file += ".tmp"; }

std::filesystem::path folder_of(const std::filesystem::path& file) {
    return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

/// Makes the rename survive a power cut. Best effort: some file systems refuse, and the file is
/// whole under one of its two names in any case.
void sync_directory_of(const std::filesystem::path& file) {
    const int directory = ::open(folder_of(file).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (directory < 0) return;
    ::fsync(directory);
    ::close(directory);
}

}  // namespace

OutputFile::OutputFile(std::filesystem::path file)
    : file_(is_special(file) ? std::move(file) : resolve_link(file)),
      temporary_(is_special(file_) ? file_ : temporary_of(file_)) {
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0) fail(file_, "cannot be written");
}

OutputFile::~OutputFile() {
    if (descriptor_ < 0) return;
    ::close(descriptor_);
    if (temporary_ != file_) ::unlink(temporary_.c_str());
}

void OutputFile::write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail(file_, "cannot be written");
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
}

void OutputFile::write(std::string_view text) { write(std::as_bytes(std::span(text))); }

void OutputFile::commit() {
    const bool in_place = temporary_ == file_;
    if (!in_place && ::fsync(descriptor_) != 0) fail(file_, "cannot be written");
    if (::close(std::exchange(descriptor_, -1)) != 0) fail(file_, "cannot be written");
    if (in_place) return;
    if (::rename(temporary_.c_str(), file_.c_str()) != 0) {
        const int reason = errno;
        ::unlink(temporary_.c_str());
        errno = reason;
        fail(file_, "cannot be replaced");
    }
    sync_directory_of(file_);
}

void require_writable(const std::filesystem::path& file) {
    const std::filesystem::path target = resolve_link(file);
    std::error_code unknown;
    if (std::filesystem::is_directory(target, unknown)) {
        errno = EISDIR;
        fail(file, "cannot be written");
    }
    const bool is_writable = is_special(target)
                                 ? ::access(target.c_str(), W_OK) == 0
                                 : ::access((folder_of(target) / ".").c_str(), W_OK | X_OK) == 0;
    if (!is_writable) fail(file, "cannot be written");
}

}  // namespace tallow
