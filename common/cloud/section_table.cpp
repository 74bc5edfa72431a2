// SPDX-License-Identifier: Apache-2.0
// Bytes of a cache file -> sections that can be trusted to be where the table says, unharmed.
// Every number comes from disk and is hostile: compared by subtraction and division, never by a
// sum or product that could wrap around, before memory is touched or allocated.
#include "common/cloud/section_table.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <tuple>

#include "common/base/errors.h"
#include "common/base/parallel.h"

namespace tallow {
namespace {

static_assert(std::endian::native == std::endian::little, "the format is little endian");
constexpr std::uint32_t kSwappedByteOrderMark = 0x04030201;
constexpr std::size_t kParallelBytes = 1 << 20;  // chosen: takes 0.1 ms to sum up on one thread

const char* kind_name(SectionKind kind) {
    switch (kind) {
        case SectionKind::fingerprint:
            return "fingerprint";
        case SectionKind::groups:
            return "groups";
        case SectionKind::body:
            return "body";
        case SectionKind::positions:
            return "positions";
        case SectionKind::normals:
            return "normals";
        case SectionKind::areas:
            return "areas";
        case SectionKind::nodes:
            return "nodes";
        case SectionKind::irradiance_direct:
            return "irradiance_direct";
        case SectionKind::directions_direct:
            return "directions_direct";
        case SectionKind::irradiance_indirect:
            return "irradiance_indirect";
        case SectionKind::directions_indirect:
            return "directions_indirect";
    }
    return nullptr;
}

bool is_global(SectionKind kind) {
    return kind == SectionKind::fingerprint || kind == SectionKind::groups;
}

bool has_group(SectionKind kind) {
    return kind >= SectionKind::irradiance_direct && kind <= SectionKind::directions_indirect;
}

auto key(const SectionEntry& entry) { return std::tuple(entry.kind, entry.body, entry.group); }

bool by_key(const SectionEntry& a, const SectionEntry& b) { return key(a) < key(b); }

}  // namespace

std::uint64_t cache_checksum(std::span<const std::byte> bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

std::string section_name(const SectionEntry& entry) {
    const char* kind = kind_name(entry.kind);
    std::string name =
        kind ? fmt::format("section '{}'", kind)
             : fmt::format("section of unknown kind {}", static_cast<std::uint32_t>(entry.kind));
    if (!is_global(entry.kind)) name += fmt::format(" of body {}", entry.body);
    if (has_group(entry.kind)) name += fmt::format(", group {}", entry.group);
    return name;
}

SectionTable::SectionTable(std::string file, std::span<const std::byte> bytes)
    : file_(std::move(file)), file_bytes_(bytes) {
    read_header();
    read_table();
    check_fields();
    check_overlaps();
    check_duplicates();
    check_checksums();
}

void SectionTable::read_header() {
    const std::size_t size = file_bytes_.size();
    if (size == 0) fail("is empty");
    if (std::memcmp(file_bytes_.data(), kCacheMagic, std::min(size, sizeof kCacheMagic)) != 0)
        throw InputError(fmt::format("{}: not a tallow cache: does not begin with TALLOW", file_));
    if (size < sizeof header_)
        fail(fmt::format("cut short: {} bytes, the header alone has {}", size, sizeof header_));
    std::memcpy(&header_, file_bytes_.data(), sizeof header_);
    if (header_.byte_order_mark == kSwappedByteOrderMark)
        fail("written on a machine of the other byte order");
    if (header_.byte_order_mark != kByteOrderMark)
        fail(fmt::format("header: expected byte-order mark {:#010x}, got {:#010x}", kByteOrderMark,
                         header_.byte_order_mark));
    if (header_.version != kCacheVersion)
        fail(fmt::format("format version {}, but this program reads version {}", header_.version,
                         kCacheVersion));
    if (header_.file_size != size)
        fail(fmt::format("header: expected a file of {} bytes, got {}", header_.file_size, size));
    if (header_.reserved != 0)
        fail(fmt::format("header: expected reserved field 0, got {}", header_.reserved));
}

void SectionTable::read_table() {
    const std::span<const std::byte> rest = file_bytes_.subspan(sizeof header_);
    if (header_.section_count > rest.size() / sizeof(SectionEntry))
        fail(fmt::format("header: {} sections, but only {} bytes left", header_.section_count,
                         rest.size()));
    const auto table = rest.first(header_.section_count * sizeof(SectionEntry));
    const std::uint64_t checksum = cache_checksum(table);
    if (checksum != header_.table_checksum)
        fail(fmt::format("section table: expected checksum {:016x}, got {:016x}",
                         header_.table_checksum, checksum));
    entries_.resize(header_.section_count);
    if (!table.empty()) std::memcpy(entries_.data(), table.data(), table.size());
    std::sort(entries_.begin(), entries_.end(), by_key);
}

void SectionTable::check_fields() const {
    for (const SectionEntry& entry : entries_) {
        if (!kind_name(entry.kind)) fail(section_name(entry));
        if (entry.reserved != 0)
            fail(entry, fmt::format("expected reserved field 0, got {}", entry.reserved));
        if (is_global(entry.kind) && entry.body != 0)
            fail(entry, fmt::format("expected body 0, got {}", entry.body));
        if (!has_group(entry.kind) && entry.group != 0)
            fail(entry, fmt::format("expected group 0, got {}", entry.group));
        if (entry.offset % kSectionAlignment != 0)
            fail(entry,
                 fmt::format("offset {} is no multiple of {}", entry.offset, kSectionAlignment));
        if (entry.offset > file_bytes_.size() || entry.length > file_bytes_.size() - entry.offset)
            fail(entry, fmt::format("{} bytes at offset {} reach beyond the end of the file, "
                                    "{} bytes",
                                    entry.length, entry.offset, file_bytes_.size()));
    }
}

void SectionTable::check_overlaps() const {
    std::vector<SectionEntry> by_offset = entries_;
    std::sort(by_offset.begin(), by_offset.end(), [](const auto& a, const auto& b) {
        return std::tuple(a.offset, a.length) < std::tuple(b.offset, b.length);
    });
    std::uint64_t free_from = sizeof header_ + entries_.size() * sizeof(SectionEntry);
    for (const SectionEntry& entry : by_offset) {
        if (entry.offset < free_from)
            fail(entry, fmt::format("begins at byte {}, but what lies before it ends at {}",
                                    entry.offset, free_from));
        free_from = entry.offset + entry.length;
    }
}

void SectionTable::check_duplicates() const {
    const auto twice =
        std::adjacent_find(entries_.begin(), entries_.end(),
                           [](const auto& a, const auto& b) { return key(a) == key(b); });
    if (twice != entries_.end()) fail(*twice, "is there twice");
}

void SectionTable::check_checksums() const {
    // Waking threads costs more than a small file does.
    const std::size_t grain = file_bytes_.size() < kParallelBytes ? entries_.size() + 1 : 1;
    std::vector<std::uint64_t> checksums(entries_.size());
    parallel_for(entries_.size(), grain,
                 [&](std::size_t i) { checksums[i] = cache_checksum(bytes(entries_[i])); });
    for (std::size_t i = 0; i < entries_.size(); ++i)
        if (checksums[i] != entries_[i].checksum)
            fail(entries_[i], fmt::format("expected checksum {:016x}, got {:016x}",
                                          entries_[i].checksum, checksums[i]));
}

std::uint32_t SectionTable::count(SectionKind kind) const {
    return static_cast<std::uint32_t>(
        std::count_if(entries_.begin(), entries_.end(),
                      [&](const SectionEntry& entry) { return entry.kind == kind; }));
}

void SectionTable::require_indices(std::uint32_t bodies, std::size_t groups) const {
    for (const SectionEntry& entry : entries_) {
        if (!is_global(entry.kind) && entry.body >= bodies)
            fail(entry, fmt::format("expected a body below {}", bodies));
        if (has_group(entry.kind) && entry.group >= groups)
            fail(entry, fmt::format("expected a group below {}", groups));
    }
}

const SectionEntry& SectionTable::find(SectionKind kind, std::uint32_t body,
                                       std::uint32_t group) const {
    const SectionEntry wanted{kind, body, group, 0, 0, 0, 0};
    const auto found = std::lower_bound(entries_.begin(), entries_.end(), wanted, by_key);
    if (found == entries_.end() || key(*found) != key(wanted)) fail(wanted, "is missing");
    return *found;
}

std::span<const std::byte> SectionTable::bytes(const SectionEntry& entry) const {
    return file_bytes_.subspan(entry.offset, entry.length);
}

std::string_view SectionTable::text(const SectionEntry& entry) const {
    const auto section = bytes(entry);
    return {reinterpret_cast<const char*>(section.data()), section.size()};
}

void SectionTable::require_items(const SectionEntry& entry, std::uint64_t count,
                                 std::size_t size) const {
    // By division: count * size may wrap around.
    if (entry.length % size != 0 || entry.length / size != count)
        fail(entry,
             fmt::format("expected {} items of {} bytes, got {} bytes", count, size, entry.length));
}

void SectionTable::fail(const SectionEntry& entry, const std::string& what) const {
    fail(section_name(entry) + ": " + what);
}

void SectionTable::fail(const std::string& what) const {
    throw InputError(fmt::format("{}: {}; re-run tallow-precompute", file_, what));
}

}  // namespace tallow
