// SPDX-License-Identifier: Apache-2.0
#pragma once

// Behind read_polygon_soup: one reader a format, all of hostile bytes. Why not OpenMesh's readers,
// which know all four formats? Tried with version 9.0 and an importer that collects polygons: of
// 30 broken files they took 20 as whole. They read a word as 0, return half of a truncated OFF or
// ASCII STL, take a missing face for the one before, pass indices out of range, reserve by the
// header's count, find 32601 faces where a comment follows "OFF", and do not come back from an
// OFF face of 2e9 corners.

#include <string>

#include "common/geometry/mesh_io.h"

namespace tallow {

/// A file in memory.
struct MeshFile {
    std::string name;  // as the user gave it, for messages
    std::string bytes;
};

// All throw InputError for what they cannot parse whole. Indices may still be out of range and
// polygons short: read_polygon_soup looks at that for all formats alike.
PolygonSoup read_ply(const MeshFile& file);
PolygonSoup read_obj(const MeshFile& file);
PolygonSoup read_off(const MeshFile& file);
PolygonSoup read_stl(const MeshFile& file);

}  // namespace tallow
