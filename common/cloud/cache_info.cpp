// SPDX-License-Identifier: Apache-2.0
// A cache for people: as text, and as points for mesh viewers.
#include "common/cloud/cache_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <numeric>

#include "common/base/output_file.h"
#include "common/geometry/surface.h"
#include "common/image/png_io.h"

namespace tallow {
namespace {

using Text = std::back_insert_iterator<std::string>;

Box bounding_box(std::span<const Vec3> positions) {
    Box box;
    for (const Vec3& p : positions) {
        box.add(p);
    }
    return box;
}

/// Mean of E_t over the surface: sum A E_t / sum A.
DVec3 mean_irradiance(std::span<const Rgb> E_t, std::span<const float> areas) {
    DVec3 flux(0);
    double area = 0;
    for (std::size_t i = 0; i < areas.size(); ++i) {
        flux += double{areas[i]} * DVec3(E_t[i].r, E_t[i].g, E_t[i].b);
        area += areas[i];
    }
    return flux / area;
}

void describe_body(Text out, const BodyView& body, const std::vector<std::string>& groups) {
    fmt::format_to(out, "  object      {}\n  samples     {}\n  nodes       {}\n", body.object,
                   body.positions.size(), body.nodes.size());
    fmt::format_to(out, "  spacing     {} mm\n  area        {} mm^2\n", body.spacing_mm,
                   body.area_mm2);
    if (body.positions.empty()) return;
    const double sum = std::accumulate(body.areas.begin(), body.areas.end(), 0.0);
    fmt::format_to(out, "  area sum    {} mm^2 ({:+.1e} of the area)\n", sum,
                   sum / body.area_mm2 - 1);
    const Box box = bounding_box(body.positions);
    fmt::format_to(out, "  bounds      ({}, {}, {}) to ({}, {}, {}) mm\n", box.low.x, box.low.y,
                   box.low.z, box.high.x, box.high.y, box.high.z);
    for (std::size_t group = 0; group < groups.size(); ++group) {
        const DVec3 mean = mean_irradiance(body.groups[group].E_t, body.areas);
        fmt::format_to(out, "  mean E_t    {:.6g} {:.6g} {:.6g} W/mm^2 of group '{}'\n", mean.x,
                       mean.y, mean.z, groups[group]);
        if (body.indirect.empty()) continue;
        const DVec3 more = mean_irradiance(body.indirect[group].E_t, body.areas);
        fmt::format_to(out, "  indirect    {:.6g} {:.6g} {:.6g} W/mm^2 of group '{}'\n", more.x,
                       more.y, more.z, groups[group]);
    }
}

Rgb total_irradiance(const BodyView& body, std::size_t sample) {
    Rgb total;
    for (const GroupIrradianceView& group : body.groups) total += group.E_t[sample];
    for (const GroupIrradianceView& group : body.indirect) total += group.E_t[sample];
    return total;
}

/// 99th percentile of the samples' largest channel, or 1 where all is dark.
float white_level(const CacheView& cache) {
    std::vector<float> levels;
    for (const BodyView& body : cache.bodies)
        for (std::size_t i = 0; i < body.positions.size(); ++i)
            levels.push_back(max_channel(total_irradiance(body, i)));
    if (levels.empty()) return 1;
    const auto percentile = levels.begin() + static_cast<std::ptrdiff_t>(levels.size() * 99 / 100);
    std::nth_element(levels.begin(), percentile, levels.end());
    return *percentile > 0 ? *percentile : 1;
}

std::string ply_header(const CacheView& cache) {
    std::size_t samples = 0;
    for (const BodyView& body : cache.bodies) samples += body.positions.size();
    std::string header = fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment tallow irradiance samples, mm\n"
        "element vertex {}\n",
        samples);
    for (const char* name :
         {"x", "y", "z", "nx", "ny", "nz", "area", "irradiance_r", "irradiance_g", "irradiance_b"})
        header += fmt::format("property float {}\n", name);
    for (const char* name : {"red", "green", "blue"})
        header += fmt::format("property uchar {}\n", name);
    return header + "property int body\nend_header\n";
}

void append_bytes(std::string& bytes, const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_vertex(std::string& bytes, const BodyView& body, std::size_t sample, float white,
                   std::int32_t index) {
    const Rgb E_t = total_irradiance(body, sample);
    append_bytes(bytes, body.positions[sample]);
    append_bytes(bytes, body.normals[sample]);
    append_bytes(bytes, body.areas[sample]);
    append_bytes(bytes, E_t);
    for (int c = 0; c < 3; ++c)
        append_bytes(bytes,
                     static_cast<std::uint8_t>(std::lround(255 * srgb_encode(E_t[c] / white))));
    append_bytes(bytes, index);
}

}  // namespace

std::string describe_cache(const MappedCache& cache) {
    const CacheView& view = cache.view();
    std::string description;
    const Text out(description);
    fmt::format_to(out, "file size     {} bytes\nformat        version {}\n", cache.file_size(),
                   kCacheVersion);
    fmt::format_to(out, "fingerprint   {}\n", fingerprint_id(view.fingerprint));
    for (const auto& [key, value] : view.fingerprint)
        fmt::format_to(out, "  {} = {}\n", key, value);
    fmt::format_to(out, "groups        {}\n", view.groups.size());
    for (const std::string& group : view.groups) fmt::format_to(out, "  '{}'\n", group);
    for (std::size_t i = 0; i < view.bodies.size(); ++i) {
        fmt::format_to(out, "body {}\n", i);
        describe_body(out, view.bodies[i], view.groups);
    }
    return description;
}

void export_ply(const std::filesystem::path& file, const CacheView& cache) {
    constexpr std::size_t kBlock = 1 << 20;  // bytes written at a time
    const float white = white_level(cache);
    OutputFile output(file);
    std::string block = ply_header(cache);
    for (std::size_t index = 0; index < cache.bodies.size(); ++index) {
        const BodyView& body = cache.bodies[index];
        for (std::size_t i = 0; i < body.positions.size(); ++i) {
            append_vertex(block, body, i, white, static_cast<std::int32_t>(index));
            if (block.size() < kBlock) continue;
            output.write(block);
            block.clear();
        }
    }
    output.write(block);
    output.commit();
}

}  // namespace tallow
