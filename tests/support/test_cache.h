// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <numeric>
#include <stdexcept>

#include "common/base/errors.h"
#include "common/cloud/cache_io.h"
#include "common/cloud/section_table.h"
#include "tests/support/test_files.h"

namespace tallow {

/// The arrays of one small body: `samples` of them, the tree a root with two leaves.
struct BodyArrays {
    explicit BodyArrays(std::uint32_t samples, std::size_t groups) {
        for (std::uint32_t i = 0; i < samples; ++i) {
            const float x = static_cast<float>(i);
            positions.emplace_back(x, 0.5f * x, 9 - x);
            normals.emplace_back(0.6f, 0, 0.8f);
            areas.push_back(0.25f + 0.125f * x);
        }
        nodes = {{0, samples, 3}, {0, samples / 2, 1}, {samples / 2, samples - samples / 2, 1}};
        for (std::size_t group = 0; group < groups; ++group) {
            const float level = static_cast<float>(group + 1);
            E_t.emplace_back(samples, Rgb(level, 2 * level, 4 * level));
            w_i.emplace_back(samples, Vec3(0, 0.5f, 0));
        }
    }

    BodyView view(std::uint32_t object) const {
        const double area = std::accumulate(areas.begin(), areas.end(), 0.0);
        BodyView body{object, 0.125f, area, positions, normals, areas, nodes, {}};
        for (std::size_t group = 0; group < E_t.size(); ++group)
            body.groups.push_back({E_t[group], w_i[group]});
        return body;
    }

    std::vector<Vec3> positions, normals;
    std::vector<float> areas;
    std::vector<OctreeNode> nodes;
    std::vector<std::vector<Rgb>> E_t;   // [group][sample]
    std::vector<std::vector<Vec3>> w_i;  // [group][sample]
};

/// Two bodies lit by two groups, and the arrays that the view points into.
struct TestCache {
    BodyArrays first{10, 2}, second{7, 2};
    CacheView view{{{"objects", "3"}, {"objects[1].eta", "1.5"}, {"sampling.light_samples", "16"}},
                   {"key", "fill light"},
                   {first.view(1), second.view(2)}};
};

/// What MappedCache says of a file, without the file's name; "ok" if it maps it.
inline std::string cache_error(const std::filesystem::path& file) {
    try {
        MappedCache cache(file);
        return "ok";
    } catch (const InputError& e) {
        const std::string message = e.what(), prefix = file.string() + ": ";
        return message.starts_with(prefix) ? message.substr(prefix.size()) : message;
    }
}

/// The bytes of a cache file to be tampered with.
class CacheBytes {
public:
    explicit CacheBytes(std::string bytes) : bytes_(std::move(bytes)) {}

    FileHeader& header() { return *reinterpret_cast<FileHeader*>(bytes_.data()); }

    std::span<SectionEntry> table() {
        auto* first = reinterpret_cast<SectionEntry*>(bytes_.data() + sizeof(FileHeader));
        return {first, header().section_count};
    }

    SectionEntry& entry(SectionKind kind, std::uint32_t body = 0, std::uint32_t group = 0) {
        for (SectionEntry& entry : table())
            if (entry.kind == kind && entry.body == body && entry.group == group) return entry;
        throw std::logic_error("no such section");
    }

    /// Item `index` of a section.
    template <class T>
    T& item(SectionKind kind, std::size_t index, std::uint32_t body = 0, std::uint32_t group = 0) {
        return reinterpret_cast<T*>(bytes_.data() + entry(kind, body, group).offset)[index];
    }

    /// Makes all checksums right for what the file now holds.
    void reseal() {
        for (SectionEntry& entry : table())
            if (entry.offset <= bytes_.size() && entry.length <= bytes_.size() - entry.offset)
                entry.checksum = cache_checksum(
                    std::as_bytes(std::span(bytes_)).subspan(entry.offset, entry.length));
        header().table_checksum = cache_checksum(std::as_bytes(table()));
    }

    const std::string& bytes() const { return bytes_; }

private:
    std::string bytes_;
};

}  // namespace tallow
