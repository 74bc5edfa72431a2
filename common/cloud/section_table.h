// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/cloud/cache_format.h"

namespace tallow {

/// XXH3, 64 bits, as cache files use it.
std::uint64_t cache_checksum(std::span<const std::byte> bytes);

/// "section 'areas' of body 0", "section 'irradiance_direct' of body 0, group 2".
std::string section_name(const SectionEntry& entry);

/// The header and section table of a file in memory. Once constructed: every section lies within
/// the file, is aligned, overlaps no other, has the checksum that the table says, and no two have
/// the same kind, body and group.
class SectionTable {
public:
    /// `bytes` is the whole file, `file` its name in messages. Throws InputError.
    SectionTable(std::string file, std::span<const std::byte> bytes);

    /// How many sections there are of `kind`.
    std::uint32_t count(SectionKind kind) const;

    /// Throws InputError for a section of a body or group beyond these numbers.
    void require_indices(std::uint32_t bodies, std::size_t groups) const;

    /// Throws InputError if there is no such section.
    const SectionEntry& find(SectionKind kind, std::uint32_t body = 0,
                             std::uint32_t group = 0) const;

    std::span<const std::byte> bytes(const SectionEntry& entry) const;

    /// A section as an array. Throws InputError if it does not hold exactly `count` items.
    template <class T>
    std::span<const T> array(const SectionEntry& entry, std::uint64_t count) const {
        static_assert(std::is_trivially_copyable_v<T> && kSectionAlignment % alignof(T) == 0);
        require_items(entry, count, sizeof(T));
        return {reinterpret_cast<const T*>(bytes(entry).data()), static_cast<std::size_t>(count)};
    }

    std::string_view text(const SectionEntry& entry) const;

    /// Throws InputError "file: section 'areas' of body 0: <what>; re-run tallow-precompute".
    [[noreturn]] void fail(const SectionEntry& entry, const std::string& what) const;
    /// The same for the file as a whole.
    [[noreturn]] void fail(const std::string& what) const;

private:
    void read_header();
    void read_table();
    void check_fields() const;
    void check_overlaps() const;
    void check_duplicates() const;
    void check_checksums() const;
    void require_items(const SectionEntry& entry, std::uint64_t count, std::size_t size) const;

    std::string file_;
    std::span<const std::byte> file_bytes_;
    FileHeader header_{};
    std::vector<SectionEntry> entries_;  // sorted by kind, body, group
};

}  // namespace tallow
