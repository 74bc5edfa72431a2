// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/stats.h"
#include "common/scene/scene.h"

namespace tallow {

/// The surfaces of a scene in world space, ready for RayScene.
struct SceneGeometry {
    std::vector<Surface> surfaces;            // [object]
    std::vector<std::uint64_t> mesh_hash;     // [object] XXH3 of the mesh file's bytes, or 0
    std::vector<std::string> repair_reports;  // one line a mesh that needed repair
};

/// Reads and repairs the meshes, applies transforms and units. Adds to the phases load and repair.
///
/// Throws   InputError for what mesh_io refuses, and for a translucent object that encloses no
///          volume: an open mesh (its boundary is named) or a disc; and for a mesh without the uvs
///          that its texture needs.
SceneGeometry load_geometry(const Scene& scene, Stats& stats);

}  // namespace tallow
