// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/geometry/mesh.h"
#include "precompute/surface_cells.h"

namespace tallow {

/// A piece of a triangle that is too small to be a sample.
struct Fragment {
    Cell cell;
    std::uint32_t triangle;
};

/// A mesh cut for a spacing h.
///
/// A triangle of area A >= h^2 makes A / h^2 pieces of equal area, rounded up or down so that the
/// sum over triangles is right. Pieces that are too long for their area, and triangles smaller than
/// h^2, become fragments no longer than 1.5 h.
struct MeshPieces {
    std::vector<Cell> cells;           // each a sample
    std::vector<std::uint32_t> whole;  // [fragment] triangles that are fragments as they are
    std::vector<Fragment> parts;       // [fragment - whole.size()] the others
    double fragment_area = 0;          // of all fragments, kept or not, mm^2

    std::size_t fragments() const { return whole.size() + parts.size(); }
    Fragment fragment(const TriangleMesh& mesh, std::size_t i) const;
};

MeshPieces cut_mesh(const TriangleMesh& mesh, float spacing);

/// About how many samples and fragments there will be, from the triangles' areas and lengths: there
/// may be far more than area / spacing^2 where triangles are long and thin.
struct WorkEstimate {
    double samples = 0, fragments = 0;
};
WorkEstimate estimate_work(const TriangleMesh& mesh, float spacing);

/// The same for counting: the number of cells in place of them, and of the fragments those that
/// `keep` wants.
struct CountedPieces {
    double cells = 0;
    MeshPieces kept;
};
CountedPieces count_pieces(const TriangleMesh& mesh, float spacing,
                           const std::function<bool(const Cell&)>& keep);

}  // namespace tallow
