// SPDX-License-Identifier: Apache-2.0
//
// File name in, polygons out: reads the file whole, hands it to the reader of its format, and
// checks what all formats have in common.

#include "common/geometry/mesh_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/check.h"
#include "common/base/errors.h"
#include "common/base/read_file.h"
#include "common/geometry/mesh_readers.h"

namespace tallow {

namespace {

using Reader = PolygonSoup (*)(const MeshFile&);

Reader reader_for(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (extension == ".ply") return read_ply;
    if (extension == ".obj") return read_obj;
    if (extension == ".off") return read_off;
    if (extension == ".stl") return read_stl;
    throw InputError(fmt::format("{}: expected a mesh file .ply, .obj, .off or .stl, got '{}'",
                                 file.string(), extension));
}

void check_vertices(const std::string& name, const PolygonSoup& soup) {
    if (soup.vertices.size() > std::numeric_limits<std::uint32_t>::max())
        throw InputError(fmt::format("{}: {} vertices are more than 32 bits can count", name,
                                     soup.vertices.size()));
    for (std::size_t i = 0; i < soup.vertices.size(); ++i)
        if (const Vec3 v = soup.vertices[i]; !is_finite(v))
            throw InputError(
                fmt::format("{}: vertex {}: expected a finite position, got ({}, {}, {})", name, i,
                            v.x, v.y, v.z));
    for (std::size_t i = 0; i < soup.normals.size(); ++i)
        if (const Vec3 n = soup.normals[i]; !is_finite(n))
            throw InputError(
                fmt::format("{}: vertex {}: expected a finite normal, got ({}, {}, {})", name, i,
                            n.x, n.y, n.z));
}

void check_polygons(const std::string& name, const PolygonSoup& soup) {
    if (soup.polygons.empty()) throw InputError(name + ": expected at least one face, got none");
    for (std::size_t i = 0; i < soup.polygons.size(); ++i) {
        const auto& polygon = soup.polygons[i];
        if (polygon.size() < 3)
            throw InputError(fmt::format("{}: face {}: expected at least three corners, got {}",
                                         name, i, polygon.size()));
        if (polygon.size() > kMostCorners)
            throw InputError(
                fmt::format("{}: face {}: expected at most {} corners, got {}; cut it "
                            "into triangles",
                            name, i, kMostCorners, polygon.size()));
        for (const std::uint32_t v : polygon)
            if (v >= soup.vertices.size())
                throw InputError(fmt::format("{}: face {}: vertex {} out of range ({} vertices)",
                                             name, i, v, soup.vertices.size()));
    }
}

void check_uvs(const std::string& name, const PolygonSoup& soup) {
    if (soup.uvs.empty()) return;
    std::size_t i = 0;
    for (std::size_t f = 0; f < soup.polygons.size(); ++f)
        for (std::size_t c = 0; c < soup.polygons[f].size(); ++c, ++i) {
            const Vec2 uv = soup.uvs[i];
            if (std::abs(uv.x) <= kLargestUv && std::abs(uv.y) <= kLargestUv) continue;  // no NaN
            throw InputError(
                fmt::format("{}: face {}: expected texture coordinates of at most {:g}, got "
                            "({}, {})",
                            name, f, kLargestUv, uv.x, uv.y));
        }
    TALLOW_CHECK(i == soup.uvs.size(), "{} corners, {} uvs", i, soup.uvs.size());
}

}  // namespace

PolygonSoup read_polygon_soup(const std::filesystem::path& file) {
    const Reader read = reader_for(file);
    const MeshFile loaded{file.string(), read_file(file, "a mesh")};
    PolygonSoup soup = read(loaded);
    check_vertices(loaded.name, soup);
    check_polygons(loaded.name, soup);
    check_uvs(loaded.name, soup);
    return soup;
}

}  // namespace tallow
