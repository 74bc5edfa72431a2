// SPDX-License-Identifier: Apache-2.0
//
// A triangle soup in, one without repeated triangles out (repair step 3).

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <map>

#include "common/geometry/edge_table.h"
#include "common/geometry/mesh_repair_steps.h"

namespace tallow {

namespace {

/// Whether a triangle turns from its smallest vertex to the middle one.
bool turns_upward(const Triangle& t) { return (t[0] < t[1]) + (t[1] < t[2]) + (t[2] < t[0]) == 2; }

/// Keeps the first of the triangles over the same vertices; returns which of those kept are
/// two-sided: had as many copies for either side.
std::vector<bool> keep_first(TriangleSoup& soup) {
    std::map<Triangle, std::size_t> place;
    std::vector<int> balance;  // [triangle kept]
    keep_triangles(soup, [&](std::size_t t) {
        Triangle sorted = soup.triangles[t];
        const int side = turns_upward(sorted) ? 1 : -1;
        std::sort(sorted.begin(), sorted.end());
        const auto [entry, is_new] = place.try_emplace(sorted, balance.size());
        if (is_new) balance.push_back(0);
        balance[entry->second] += side;
        return is_new;
    });
    std::vector<bool> two_sided;
    for (const int sides : balance) two_sided.push_back(sides == 0);
    return two_sided;
}

/// Which two-sided triangles are walls: sheets at whose edges all else is paired without them.
std::vector<bool> find_walls(const TriangleSoup& soup, const std::vector<bool>& two_sided) {
    const EdgeTable edges(soup.triangles, soup.vertices.size());
    boost::disjoint_sets_with_storage<> sheet(two_sided.size());
    for (std::size_t e = 0; e < edges.size(); ++e) {
        std::size_t last = two_sided.size();
        for (const std::uint32_t h : edges.around(e)) {
            if (!two_sided[h / 3]) continue;
            if (last < two_sided.size()) sheet.union_set(last, std::size_t{h / 3});
            last = h / 3;
        }
    }
    std::vector<bool> needed(two_sided.size(), false), hangs(needed);  // [sheet]
    for (std::size_t e = 0; e < edges.size(); ++e) {
        const auto around = edges.around(e);
        const auto others =
            std::ranges::count_if(around, [&](auto h) { return !two_sided[h / 3]; });
        for (const std::uint32_t h : around) {
            const std::size_t k = sheet.find_set(std::size_t{h / 3});
            if (others % 2 == 1) needed[k] = true;
            if (others > 0) hangs[k] = true;
        }
    }
    std::vector<bool> wall(two_sided.size(), false);
    for (std::size_t t = 0; t < wall.size(); ++t)
        if (const std::size_t k = sheet.find_set(t); two_sided[t]) wall[t] = hangs[k] && !needed[k];
    return wall;
}

}  // namespace

void drop_duplicates(TriangleSoup& soup, RepairReport& report) {
    const std::size_t before = soup.triangles.size();
    const std::vector<bool> two_sided = keep_first(soup);
    report.duplicate_faces = before - soup.triangles.size();
    if (std::ranges::none_of(two_sided, [](bool both) { return both; })) return;
    const std::vector<bool> wall = find_walls(soup, two_sided);
    keep_triangles(soup, [&](std::size_t t) { return !wall[t]; });
    report.duplicate_faces = before - soup.triangles.size();
}

}  // namespace tallow
