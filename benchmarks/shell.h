// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "common/base/vec.h"
#include "common/cloud/point_octree.h"
#include "common/geometry/mesh.h"
#include "common/nbody/kernel_table.h"
#include "common/optics/medium.h"

namespace tallow {

/// Samples of a bumpy sphere of 40 mm, lit from one side, as pass one would leave them: one
/// scattered point a cell, all cells of about the same area.
struct Shell {
    std::vector<Vec3> position;  // [sample] mm, in Morton order
    std::vector<float> weight;   // [sample] W
    std::vector<float> area;     // [sample] mm^2
    std::vector<OctreeNode> nodes;
};

/// The bumpy sphere as a closed, flat mesh of 131072 triangles.
TriangleMesh shell_mesh();

/// Made at the first call for a size, and kept.
const Shell& shell(std::size_t samples);

/// The same points before they are sorted.
std::vector<Vec3> scattered_points(std::size_t count);

/// About `count` points on the side of the shell that faces +z, row by row as a camera sees them.
std::vector<Vec3> seen_points(std::size_t count);

/// Marble of [JMLH01] and the kernel of its green channel under the dipole.
const Medium& marble();
KernelTable marble_table();

}  // namespace tallow
