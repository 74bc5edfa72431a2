// SPDX-License-Identifier: Apache-2.0
//
// A triangle soup in, an oriented manifold, perhaps in pieces, out (repair step 5): CGAL orients
// it and takes it apart where it is none; then the majority of each piece has its way.
// Source: CGAL 5.5 manual, "Polygon Mesh Processing", orient_polygon_soup; Gueziec et al. 2001,
// "Cutting and Stitching".

#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <numeric>

#include "common/geometry/mesh_repair_steps.h"

namespace tallow {

namespace {

namespace pmp = CGAL::Polygon_mesh_processing;

/// Notes which triangles CGAL turns around.
struct TurnRecorder : pmp::Default_orientation_visitor {
    std::vector<bool>* turned;
    explicit TurnRecorder(std::vector<bool>& flags) : turned(&flags) {}
    void polygon_orientation_reversed(std::size_t t) const { (*turned)[t] = !(*turned)[t]; }
};

/// Turns pieces most of whose triangles CGAL has turned: the file's majority decides, not its
/// first triangle. Returns how many triangles then differ from the file.
std::size_t follow_majority(TriangleSoup& soup, const std::vector<bool>& turned) {
    boost::disjoint_sets_with_storage<> piece(soup.vertices.size());
    for (const auto [a, b, c] : soup.triangles) {
        piece.union_set(std::size_t{a}, std::size_t{b});
        piece.union_set(std::size_t{a}, std::size_t{c});
    }
    const auto piece_of = [&](std::size_t t) {
        return piece.find_set(std::size_t{soup.triangles[t][0]});
    };
    std::vector<std::size_t> size(soup.vertices.size(), 0), reversed(size);
    for (std::size_t t = 0; t < turned.size(); ++t) {
        ++size[piece_of(t)];
        reversed[piece_of(t)] += turned[t];
    }
    for (std::size_t t = 0; t < turned.size(); ++t)
        if (2 * reversed[piece_of(t)] > size[piece_of(t)])
            std::swap(soup.triangles[t][1], soup.triangles[t][2]);
    std::size_t changed = 0;
    for (std::size_t k = 0; k < size.size(); ++k)
        changed += std::min(reversed[k], size[k] - reversed[k]);
    return changed;
}

}  // namespace

std::vector<std::uint32_t> orient_neighbours(TriangleSoup& soup, RepairReport& report) {
    // The algorithm never looks at the points, only copies them: given the vertices' numbers as
    // points, it tells of what vertex each of its copies is one.
    std::vector<std::uint32_t> copy_of(soup.vertices.size());
    std::iota(copy_of.begin(), copy_of.end(), 0u);
    std::vector<bool> turned(soup.triangles.size(), false);
    pmp::orient_polygon_soup(copy_of, soup.triangles,
                             CGAL::parameters::visitor(TurnRecorder(turned)));
    report.split_vertices = copy_of.size() - soup.vertices.size();
    for (std::size_t v = soup.vertices.size(); v < copy_of.size(); ++v)
        soup.vertices.push_back(soup.vertices[copy_of[v]]);
    report.flipped_faces = follow_majority(soup, turned);
    return copy_of;
}

}  // namespace tallow
