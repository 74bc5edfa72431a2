// SPDX-License-Identifier: Apache-2.0
//
// A triangle soup in, one without fins out (repair step 4). Fins are what a cluster of triangles
// loses if triangles with a free edge are peeled off until none is left: the rest, if any, is
// closed.

#include <boost/pending/disjoint_sets.hpp>

#include "common/geometry/edge_table.h"
#include "common/geometry/mesh_repair_steps.h"

namespace tallow {

namespace {

/// Fins of a cluster, measured against the closed rest. Chosen: a thing half as large as what it
/// hangs on would pass for a fin if this were doubled, yet is likelier a body with a hole.
constexpr double kLargestFin = 0.25;

class Peeler {
public:
    explicit Peeler(const TriangleSoup& soup)
        : soup_(soup),
          edges_(soup.triangles, soup.vertices.size()),
          edge_of_(3 * soup.triangles.size()),
          uses_(edges_.size()),
          peeled_(soup.triangles.size(), false) {
        for (std::size_t e = 0; e < edges_.size(); ++e) {
            uses_[e] = edges_.around(e).size();
            has_junction_ = has_junction_ || uses_[e] > 2;
            for (const std::uint32_t h : edges_.around(e)) edge_of_[h] = e;
        }
    }

    /// [triangle] whether it is part of a fin; empty if there are none.
    std::vector<bool> fins() {
        if (!has_junction_) return {};
        for (std::size_t e = 0; e < edges_.size(); ++e)
            if (uses_[e] == 1) free_.push_back(e);
        while (!free_.empty()) peel_at_free_edge();
        return small_ones();
    }

private:
    void peel_at_free_edge() {
        const std::size_t edge = free_.back();
        free_.pop_back();
        for (const std::uint32_t h : edges_.around(edge)) {
            const std::uint32_t t = h / 3;
            if (peeled_[t]) continue;
            peeled_[t] = true;
            for (std::size_t c = 0; c < 3; ++c)
                if (const std::size_t e = edge_of_[3 * t + c]; --uses_[e] == 1) free_.push_back(e);
        }
    }

    /// The peeled triangles of those clusters that are not all, nor for a large part, peeled.
    std::vector<bool> small_ones() {
        boost::disjoint_sets_with_storage<> cluster(soup_.triangles.size());
        for (std::size_t e = 0; e < edges_.size(); ++e)
            for (const std::uint32_t h : edges_.around(e))
                cluster.union_set(std::size_t{h / 3}, std::size_t{edges_.around(e)[0] / 3});
        std::vector<double> fin_area(peeled_.size(), 0), rest_area(peeled_.size(), 0);
        const TriangleMesh mesh{soup_.vertices, soup_.triangles, {}};
        for (std::size_t t = 0; t < peeled_.size(); ++t)
            (peeled_[t] ? fin_area : rest_area)[cluster.find_set(t)] += triangle_area(mesh, t);
        std::vector<bool> fin(peeled_.size(), false);
        for (std::size_t t = 0; t < peeled_.size(); ++t) {
            const std::size_t k = cluster.find_set(t);
            fin[t] = peeled_[t] && fin_area[k] <= kLargestFin * rest_area[k];
        }
        return fin;
    }

    const TriangleSoup& soup_;
    EdgeTable edges_;
    std::vector<std::size_t> edge_of_;  // [half-edge]
    std::vector<std::size_t> uses_;     // [edge] by triangles not yet peeled
    std::vector<bool> peeled_;          // [triangle]
    std::vector<std::size_t> free_;     // edges of one use, not yet peeled at
    bool has_junction_ = false;         // three triangles or more at an edge
};

}  // namespace

void drop_fins(TriangleSoup& soup, RepairReport& report) {
    const std::vector<bool> fin = Peeler(soup).fins();
    if (fin.empty()) return;
    keep_triangles(soup, [&](std::size_t t) { return !fin[t]; });
    report.fin_faces = fin.size() - soup.triangles.size();
}

}  // namespace tallow
