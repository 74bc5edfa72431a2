// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/cloud/point_octree.h"

// The contract between the two stages: what a .tallow file holds. docs/CACHE_FORMAT.md draws it.
//
// FileHeader | SectionEntry[section_count] | sections, each at a multiple of kSectionAlignment.
// Little endian. All lengths in bytes. Samples of a body are in Morton order, so that its tree's
// nodes own contiguous ranges.
namespace tallow {

inline constexpr char kCacheMagic[8] = {'T', 'A', 'L', 'L', 'O', 'W', '\r', '\n'};
inline constexpr std::uint32_t kCacheVersion = 2;
inline constexpr std::uint32_t kByteOrderMark = 0x01020304;
inline constexpr std::uint64_t kSectionAlignment = 64;

struct FileHeader {
    char magic[8];
    std::uint32_t version;
    std::uint32_t byte_order_mark;
    std::uint64_t file_size;
    std::uint32_t section_count;
    std::uint32_t reserved;        // 0
    std::uint64_t table_checksum;  // XXH3 of the section table
};
static_assert(sizeof(FileHeader) == 40);

enum class SectionKind : std::uint32_t {
    fingerprint = 1,           // text, see Fingerprint
    groups = 2,                // text, one light group's name a line
    body = 3,                  // BodyRecord
    positions = 4,             // Vec3[sample], mm
    normals = 5,               // Vec3[sample], unit, outward
    areas = 6,                 // float[sample], mm^2
    nodes = 7,                 // OctreeNode[node]
    irradiance_direct = 8,     // Rgb[sample], of one group
    directions_direct = 9,     // Vec3[sample], of one group
    irradiance_indirect = 10,  // Rgb[sample], of one group; light that was reflected before
    directions_indirect = 11,  // Vec3[sample], of one group
};

struct SectionEntry {
    SectionKind kind;
    std::uint32_t body;   // 0 where the kind has none
    std::uint32_t group;  // 0 where the kind has none
    std::uint32_t reserved;
    std::uint64_t offset;
    std::uint64_t length;
    std::uint64_t checksum;  // XXH3 of the section's bytes
};
static_assert(sizeof(SectionEntry) == 40);

/// A translucent body that was sampled.
struct BodyRecord {
    std::uint32_t object;  // index of the object in the scene
    std::uint32_t sample_count;
    std::uint32_t node_count;
    float spacing_mm;  // wished-for distance of neighbouring samples
    double area_mm2;   // of the surface; the samples' areas sum to it
};
static_assert(sizeof(BodyRecord) == 24);

/// Everything the cache's content depends on, as readable pairs in a fixed order, for example
/// {"objects[0].mesh", "xxh3:9f86d081884c7d65"}, {"objects[0].eta", "1.5"}. Keys hold no '=' and
/// no line break. Compared pair by pair, so that a mismatch can name both values. Keys that start
/// with "indirect." name what only indirect light depends on, with "sampling." how the samples were
/// taken.
using Fingerprint = std::vector<std::pair<std::string, std::string>>;

}  // namespace tallow
