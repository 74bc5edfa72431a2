// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "precompute/triangle_cells.h"

namespace tallow {

/// One sample for several fragments: their exact area, their centroid, their mean normal.
struct Cluster {
    Cell cell;
    Vec3 ray_origin;  // the fragment's centre that is nearest to the centroid: on the surface
};

/// Clusters fragments that hang together and face the same way, into cells of about spacing^2:
///
/// - fragments of one cube of side 8 h whose normals point through the same side of a cube, and
///   that are connected through shared vertices, form a patch (patches below h^2 / 8 in one cube
///   and direction form one together, or noise would make a cell of each of its triangles);
/// - a patch of area A is halved across its longest extent until there are A / h^2 clusters, none
///   longer than 2 h;
/// - a cluster is parted where more than a hundredth of its area faces more than 40 degrees away
///   from its mean normal.
///
/// So no cluster holds both sides of a thin sheet or of a sharp edge, or two sheets that lie on one
/// another. The same for any number of threads.
std::vector<Cluster> cluster_fragments(const TriangleMesh& mesh, const MeshPieces& pieces,
                                       float spacing);

/// Which part of the fragments is clustered, to count clusters without making all of them: all
/// those in one of `every` cubes.
struct CubeSubset {
    float spacing;
    std::uint64_t every;

    bool contains(const Cell& cell) const;
};

}  // namespace tallow
