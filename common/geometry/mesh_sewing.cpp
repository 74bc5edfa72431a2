// SPDX-License-Identifier: Apache-2.0
//
// An oriented manifold with slits in, one without out (repair step 6). Borders that lie on each
// other have been one edge of more than two triangles, which step 5 took apart; they are paired
// and their vertices joined again, as long as the surface stays a manifold. CGAL's stitch_borders
// is not used: it leaves borders alone of which more than two lie on each other.

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <map>

#include "common/geometry/edge_table.h"
#include "common/geometry/mesh_repair_steps.h"

namespace tallow {

namespace {

/// A border half-edge, seen along its line from the smaller vertex.
struct Seam {
    std::uint32_t half_edge;
    bool forward;  // runs along the line
    double angle;  // of its triangle around the line
};

using HalfEdgePair = std::pair<std::uint32_t, std::uint32_t>;

double angle_around(DVec3 from, DVec3 to, DVec3 p) {
    const DVec3 axis = glm::normalize(to - from);
    const DVec3 least = glm::abs(axis.x) < 0.5 ? DVec3(1, 0, 0) : DVec3(0, 1, 0);
    const DVec3 u = glm::normalize(glm::cross(axis, least)), v = glm::cross(axis, u);
    return std::atan2(glm::dot(p - from, v), glm::dot(p - from, u));
}

/// Pairs triangles around one line across the inside of the body, so that bodies which touch stay
/// two. A triangle that runs backward has its inside at larger angles, one that runs forward at
/// smaller ones: they match like parentheses, twice around the circle. (Sheets that cross nest.)
void match(std::vector<Seam>& around, std::vector<HalfEdgePair>& pairs) {
    std::stable_sort(around.begin(), around.end(),
                     [](const Seam& a, const Seam& b) { return a.angle < b.angle; });
    std::vector<std::uint32_t> waiting;
    std::vector<bool> matched(around.size(), false);
    for (std::size_t i = 0; i < 2 * around.size(); ++i) {
        const std::size_t k = i % around.size();
        if (!around[k].forward) {
            if (i == k) waiting.push_back(around[k].half_edge);
        } else if (!matched[k] && !waiting.empty()) {
            pairs.emplace_back(waiting.back(), around[k].half_edge);
            waiting.pop_back();
            matched[k] = true;
        }
    }
}

std::vector<HalfEdgePair> find_pairs(const TriangleSoup& soup,
                                     std::span<const std::uint32_t> copy_of) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Seam>> lines;
    const EdgeTable edges(soup.triangles, soup.vertices.size());
    for (std::size_t e = 0; e < edges.size(); ++e) {
        if (edges.around(e).size() != 1) continue;
        const std::uint32_t h = edges.around(e)[0];
        const std::uint32_t a = copy_of[source(soup.triangles, h)];
        const std::uint32_t b = copy_of[target(soup.triangles, h)];
        const Vec3 apex = soup.vertices[source(soup.triangles, previous_half_edge(h))];
        const auto [low, high] = std::minmax(a, b);
        const double angle = angle_around(soup.vertices[low], soup.vertices[high], apex);
        lines[{low, high}].push_back({h, a < b, angle});
    }
    std::vector<HalfEdgePair> pairs;
    for (auto& [line, around] : lines) match(around, pairs);
    return pairs;
}

/// What each vertex becomes a part of if the pairs are sewn.
std::vector<std::uint32_t> join_vertices(const TriangleSoup& soup,
                                         std::span<const HalfEdgePair> pairs) {
    boost::disjoint_sets_with_storage<> sets(soup.vertices.size());
    for (const auto& [h, g] : pairs) {
        sets.union_set(std::size_t{source(soup.triangles, h)},
                       std::size_t{target(soup.triangles, g)});
        sets.union_set(std::size_t{target(soup.triangles, h)},
                       std::size_t{source(soup.triangles, g)});
    }
    std::vector<std::uint32_t> joined(soup.vertices.size());
    for (std::size_t v = 0; v < joined.size(); ++v)
        joined[v] = static_cast<std::uint32_t>(sets.find_set(v));
    return joined;
}

/// [joined vertex] whether it has a directed edge that two triangles use. Sewing along edges keeps
/// the triangles around a vertex one fan; such edges are all that it can spoil.
std::vector<bool> find_spoilt(const TriangleSoup& soup, std::span<const std::uint32_t> joined) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> directed;
    for (std::uint32_t h = 0; h < 3 * soup.triangles.size(); ++h)
        directed.emplace_back(joined[source(soup.triangles, h)], joined[target(soup.triangles, h)]);
    std::sort(directed.begin(), directed.end());
    std::vector<bool> spoilt(soup.vertices.size(), false);
    for (std::size_t i = 1; i < directed.size(); ++i)
        if (directed[i] == directed[i - 1])
            spoilt[directed[i].first] = spoilt[directed[i].second] = true;
    return spoilt;
}

}  // namespace

void sew_slits(TriangleSoup& soup, std::span<const std::uint32_t> copy_of, RepairReport& report) {
    std::vector<HalfEdgePair> pairs = find_pairs(soup, copy_of);
    std::vector<std::uint32_t> joined;
    for (std::size_t given_up = 1; given_up > 0;) {
        joined = join_vertices(soup, pairs);
        const std::vector<bool> spoilt = find_spoilt(soup, joined);
        given_up = std::erase_if(pairs, [&](const HalfEdgePair& pair) {
            return spoilt[joined[source(soup.triangles, pair.first)]] ||
                   spoilt[joined[target(soup.triangles, pair.first)]];
        });
    }
    for (Triangle& t : soup.triangles)
        for (std::uint32_t& v : t) v = joined[v];
    for (std::size_t v = 0; v < joined.size(); ++v) report.split_vertices -= joined[v] != v;
}

}  // namespace tallow
