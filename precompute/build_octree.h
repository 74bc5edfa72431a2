// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "common/cloud/point_octree.h"

namespace tallow {

/// Builds the linear octree over points that are in Morton order (as sample_surface leaves them).
/// A node is split at the first octant boundary that parts its points, so that no node has a
/// single child. Empty for no points.
///
/// Source   [JB02] section 3.2 for the octree; Warren, Salmon 1993 for the linear form.
std::vector<OctreeNode> build_octree(std::span<const Vec3> positions);

}  // namespace tallow
