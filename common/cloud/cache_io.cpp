// SPDX-License-Identifier: Apache-2.0
// Cache in memory <-> .tallow file. Writing lays the sections out one after another; reading maps
// the file, lets SectionTable and check_body() examine it and points into it.
#include "common/cloud/cache_io.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <limits>
#include <set>

#include "common/base/check.h"
#include "common/base/errors.h"
#include "common/base/output_file.h"
#include "common/cloud/check_body.h"
#include "common/cloud/fingerprint_text.h"
#include "common/cloud/section_table.h"

namespace tallow {
namespace {

static_assert(sizeof(Vec3) == 12 && sizeof(Rgb) == 12 && sizeof(OctreeNode) == 12);

constexpr std::uint64_t align_up(std::uint64_t offset) {
    return (offset + kSectionAlignment - 1) / kSectionAlignment * kSectionAlignment;
}

/// Collects sections, then writes them behind a header and a table. What it is given must live
/// until write().
class CacheWriter {
public:
    template <class T>
    void add(SectionKind kind, std::uint32_t body, std::uint32_t group, std::span<const T> items) {
        add_bytes(kind, body, group, std::as_bytes(items));
    }

    void write(OutputFile& file) {
        std::uint64_t offset = sizeof(FileHeader) + entries_.size() * sizeof(SectionEntry);
        for (SectionEntry& entry : entries_) {
            entry.offset = align_up(offset);
            offset = entry.offset + entry.length;
        }
        const auto table = std::as_bytes(std::span(entries_));
        FileHeader header{{},
                          kCacheVersion,
                          kByteOrderMark,
                          offset,
                          static_cast<std::uint32_t>(entries_.size()),
                          0,
                          cache_checksum(table)};
        std::memcpy(header.magic, kCacheMagic, sizeof kCacheMagic);
        file.write(std::as_bytes(std::span(&header, 1)));
        file.write(table);
        write_sections(file, sizeof header + table.size());
    }

private:
    void add_bytes(SectionKind kind, std::uint32_t body, std::uint32_t group,
                   std::span<const std::byte> bytes) {
        entries_.push_back({kind, body, group, 0, 0, bytes.size(), cache_checksum(bytes)});
        contents_.push_back(bytes);
    }

    void write_sections(OutputFile& file, std::uint64_t position) const {
        constexpr std::byte kPadding[kSectionAlignment] = {};
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            file.write(std::span(kPadding).first(entries_[i].offset - position));
            file.write(contents_[i]);
            position = entries_[i].offset + entries_[i].length;
        }
    }

    std::vector<SectionEntry> entries_;
    std::vector<std::span<const std::byte>> contents_;  // [section]
};

BodyRecord make_record(const BodyView& body) {
    constexpr std::size_t kMost = std::numeric_limits<std::uint32_t>::max();
    TALLOW_CHECK(body.positions.size() <= kMost && body.nodes.size() <= kMost,
                 "{} samples, {} nodes", body.positions.size(), body.nodes.size());
    return {body.object, static_cast<std::uint32_t>(body.positions.size()),
            static_cast<std::uint32_t>(body.nodes.size()), body.spacing_mm, body.area_mm2};
}

void add_body(CacheWriter& writer, std::uint32_t index, const BodyView& body,
              const BodyRecord& record) {
    const std::size_t samples = body.positions.size();
    TALLOW_CHECK(body.normals.size() == samples && body.areas.size() == samples,
                 "{} positions, {} normals, {} areas", samples, body.normals.size(),
                 body.areas.size());
    writer.add(SectionKind::body, index, 0, std::span(&record, 1));
    writer.add(SectionKind::positions, index, 0, body.positions);
    writer.add(SectionKind::normals, index, 0, body.normals);
    writer.add(SectionKind::areas, index, 0, body.areas);
    writer.add(SectionKind::nodes, index, 0, body.nodes);
    const auto add_light = [&](const std::vector<GroupIrradianceView>& groups,
                               SectionKind irradiance, SectionKind directions) {
        for (std::uint32_t group = 0; group < groups.size(); ++group) {
            const GroupIrradianceView& light = groups[group];
            TALLOW_CHECK(light.E_t.size() == samples && light.w_i.size() == samples,
                         "{} samples, {} irradiances, {} directions", samples, light.E_t.size(),
                         light.w_i.size());
            writer.add(irradiance, index, group, light.E_t);
            writer.add(directions, index, group, light.w_i);
        }
    };
    add_light(body.groups, SectionKind::irradiance_direct, SectionKind::directions_direct);
    add_light(body.indirect, SectionKind::irradiance_indirect, SectionKind::directions_indirect);
}

/// A body as the table describes it; its sections have the lengths that its counts ask for.
BodyView read_body(const SectionTable& table, std::uint32_t index, std::size_t groups) {
    const BodyRecord record =
        table.array<BodyRecord>(table.find(SectionKind::body, index), 1).front();
    const auto section = [&]<class T>(SectionKind kind, std::uint32_t count, std::uint32_t group,
                                      std::span<const T>& items) {
        items = table.array<T>(table.find(kind, index, group), count);
    };
    BodyView body{record.object, record.spacing_mm, record.area_mm2, {}, {}, {}, {}, {}, {}};
    section(SectionKind::positions, record.sample_count, 0, body.positions);
    section(SectionKind::normals, record.sample_count, 0, body.normals);
    section(SectionKind::areas, record.sample_count, 0, body.areas);
    section(SectionKind::nodes, record.node_count, 0, body.nodes);
    for (std::uint32_t group = 0; group < groups; ++group) {
        GroupIrradianceView& light = body.groups.emplace_back();
        section(SectionKind::irradiance_direct, record.sample_count, group, light.E_t);
        section(SectionKind::directions_direct, record.sample_count, group, light.w_i);
    }
    if (table.count(SectionKind::irradiance_indirect) == 0) return body;
    for (std::uint32_t group = 0; group < groups; ++group) {
        GroupIrradianceView& light = body.indirect.emplace_back();
        section(SectionKind::irradiance_indirect, record.sample_count, group, light.E_t);
        section(SectionKind::directions_indirect, record.sample_count, group, light.w_i);
    }
    return body;
}

CacheView read_cache(const SectionTable& table) {
    CacheView cache;
    const SectionEntry& fingerprint = table.find(SectionKind::fingerprint);
    if (auto pairs = decode_fingerprint(table.text(fingerprint)))
        cache.fingerprint = std::move(*pairs);
    else
        table.fail(fingerprint, "expected lines of the form key=value");
    const SectionEntry& groups = table.find(SectionKind::groups);
    if (auto names = decode_lines(table.text(groups)))
        cache.groups = std::move(*names);
    else
        table.fail(groups, "the last line has no end");

    const std::uint32_t bodies = table.count(SectionKind::body);
    table.require_indices(bodies, cache.groups.size());
    std::set<std::uint32_t> objects;
    for (std::uint32_t i = 0; i < bodies; ++i) {
        const BodyView body = read_body(table, i, cache.groups.size());
        if (!objects.insert(body.object).second)
            table.fail(table.find(SectionKind::body, i),
                       fmt::format("object {} has a body already", body.object));
        check_body(table, i, body);
        cache.bodies.push_back(body);
    }
    return cache;
}

}  // namespace

void write_cache(const std::filesystem::path& file, const CacheView& cache) {
    const std::string fingerprint = encode_fingerprint(cache.fingerprint);
    const std::string groups = encode_lines(cache.groups);
    std::vector<BodyRecord> records;
    for (const BodyView& body : cache.bodies) records.push_back(make_record(body));

    CacheWriter writer;
    writer.add<char>(SectionKind::fingerprint, 0, 0, fingerprint);
    writer.add<char>(SectionKind::groups, 0, 0, groups);
    for (std::uint32_t i = 0; i < cache.bodies.size(); ++i) {
        TALLOW_CHECK(cache.bodies[i].groups.size() == cache.groups.size(), "{} groups, {} names",
                     cache.bodies[i].groups.size(), cache.groups.size());
        TALLOW_CHECK(cache.bodies[i].indirect.size() == cache.bodies[0].indirect.size() &&
                         (cache.bodies[i].indirect.empty() ||
                          cache.bodies[i].indirect.size() == cache.groups.size()),
                     "{} groups of indirect light, {} names", cache.bodies[i].indirect.size(),
                     cache.groups.size());
        add_body(writer, i, cache.bodies[i], records[i]);
    }
    OutputFile output(file);
    writer.write(output);
    output.commit();
}

/// The bytes of a file, read only. Unmapped when it dies.
struct MappedCache::Mapping {
    explicit Mapping(const std::filesystem::path& file) {
        // O_NONBLOCK: a pipe must be refused below instead of waiting for its writer.
        const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
        if (descriptor < 0) fail(file, "cannot open", errno);
        struct stat status {};
        const int reason = ::fstat(descriptor, &status) == 0 ? map(descriptor, status) : errno;
        ::close(descriptor);
        if (reason != 0) fail(file, "cannot read", reason);
    }
    ~Mapping() {
        if (data) ::munmap(data, size);
    }
    Mapping(const Mapping&) = delete;
    Mapping& operator=(const Mapping&) = delete;

    std::span<const std::byte> bytes() const { return {static_cast<const std::byte*>(data), size}; }

    void* data = nullptr;
    std::size_t size = 0;

private:
    /// Returns the reason of a failure, or 0.
    int map(int descriptor, const struct stat& status) {
        if (S_ISDIR(status.st_mode)) return EISDIR;
        if (!S_ISREG(status.st_mode)) return EINVAL;
        if (status.st_size == 0) return 0;  // cannot be mapped, and is refused for what it is later
        size = static_cast<std::size_t>(status.st_size);
        // Not populated at once: the checks touch the pages on all threads, which is faster.
        void* mapped = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
        if (mapped == MAP_FAILED) return errno;
        data = mapped;
        return 0;
    }

    [[noreturn]] static void fail(const std::filesystem::path& file, const char* what, int reason) {
        throw InputError(fmt::format("{}: {}: {}", file.string(), what, std::strerror(reason)));
    }
};

MappedCache::MappedCache(const std::filesystem::path& file)
    : mapping_(std::make_unique<Mapping>(file)),
      view_(read_cache(SectionTable(file.string(), mapping_->bytes()))) {}

MappedCache::~MappedCache() = default;
MappedCache::MappedCache(MappedCache&&) noexcept = default;
MappedCache& MappedCache::operator=(MappedCache&&) noexcept = default;

std::uint64_t MappedCache::file_size() const { return mapping_->size; }

}  // namespace tallow
