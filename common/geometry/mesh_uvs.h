// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "common/geometry/mesh.h"
#include "common/geometry/mesh_io.h"

namespace tallow {

/// Texture coordinates for the corners of a repaired mesh, three a triangle: those that its polygon
/// in the file has at the same position. What belongs to a position may differ from polygon to
/// polygon, so that seams stay where they are. A vertex that repair has put on a polygon's border
/// gets what lies between the border's ends. `polygon` is, for each triangle, that of the file.
/// `file.uvs` must not be empty.
std::vector<Vec2> find_corner_uvs(const TriangleMesh& mesh, std::span<const std::uint32_t> polygon,
                                  const PolygonSoup& file);

}  // namespace tallow
