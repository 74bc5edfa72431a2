// SPDX-License-Identifier: Apache-2.0
#pragma once

// Behind read_polygon_soup: one reader a format, all of hostile bytes. Why not OpenMesh's readers,
// which know all four formats? Those of version 9.0, tried with broken files, took truncated files,
// words in place of numbers and indices out of range for whole, and did not return from two OFF
// files with hostile counts.

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
