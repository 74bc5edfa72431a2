// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/cloud/cache_format.h"

namespace tallow {

/// One sampled body. The spans point into memory that somebody else owns: the writer's arrays, or
/// the mapped file.
struct BodyView {
    std::uint32_t object;
    float spacing_mm;
    double area_mm2;
    std::span<const Vec3> positions;              // [sample] mm
    std::span<const Vec3> normals;                // [sample]
    std::span<const float> areas;                 // [sample] mm^2
    std::span<const OctreeNode> nodes;            // depth first; empty only if there are no samples
    std::vector<GroupIrradianceView> groups;      // [group] light that came straight
    std::vector<GroupIrradianceView> indirect{};  // [group] light that was reflected; or empty
};

struct CacheView {
    Fingerprint fingerprint;
    std::vector<std::string> groups;  // names of the light groups
    std::vector<BodyView> bodies;
};

/// Writes `name.tmp`, syncs, renames: a killed run or a full disk leaves an old file whole.
/// Throws OutputError.
void write_cache(const std::filesystem::path& file, const CacheView& cache);

/// A cache file mapped into memory and completely validated: header, section table, checksums,
/// counts, finite and positive numbers, unit normals, structure of every tree.
class MappedCache {
public:
    /// Throws InputError "x.tallow: section 'areas' of body 0: ...; re-run tallow-precompute".
    explicit MappedCache(const std::filesystem::path& file);
    ~MappedCache();
    MappedCache(MappedCache&&) noexcept;
    MappedCache& operator=(MappedCache&&) noexcept;

    const CacheView& view() const { return view_; }
    std::uint64_t file_size() const;

private:
    struct Mapping;
    std::unique_ptr<Mapping> mapping_;
    CacheView view_;
};

/// Throws InputError naming the first differing pair of what the cache was made from and what the
/// scene needs now: "x.tallow: made from objects[0].mesh = xxh3:..., but the scene has xxh3:...;
/// re-run tallow-precompute". Pairs whose key starts with "sampling." say how the cache was made
/// and are not compared. Nor are those that start with "indirect." if the scene's say that it wants
/// no indirect light: then what the cache has of it is left out.
void require_fingerprint(const std::filesystem::path& cache_file, const Fingerprint& cache,
                         const Fingerprint& scene);

/// Short stable name of a fingerprint: 16 hexadecimal digits of its XXH3.
std::string fingerprint_id(const Fingerprint& fingerprint);

}  // namespace tallow
