// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/base/vec.h"

namespace tallow {

/// Cutting a polygon takes its corners squared; no file that means well has one of so many.
inline constexpr std::size_t kMostCorners = 4096;

/// Largest texture coordinate. Chosen: float has no fractions left there, and products with it are
/// far from overflow.
inline constexpr float kLargestUv = 1e9f;

/// Polygons as a file lists them: nothing is promised but that indices are in range, coordinates
/// are finite and each polygon has 3 to kMostCorners corners. May be open, non-manifold,
/// unoriented.
struct PolygonSoup {
    std::vector<Vec3> vertices;                        // in the file's unit
    std::vector<Vec3> normals;                         // one a vertex, or empty
    std::vector<std::vector<std::uint32_t>> polygons;  // vertex indices
    std::vector<Vec2> uvs{};  // of the polygons' corners, one polygon after the other, or empty
    std::size_t corners_without_uv = 0;  // of a file that has some: theirs are 0
};

/// Reads PLY (ascii, binary little and big endian), OBJ, OFF or STL (ascii, binary); the file's
/// extension tells which.
///
/// Throws   InputError, located: "bunny.ply: face 812: vertex 40111 out of range (34834 vertices)".
PolygonSoup read_polygon_soup(const std::filesystem::path& file);

}  // namespace tallow
