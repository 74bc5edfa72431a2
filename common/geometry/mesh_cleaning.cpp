// SPDX-License-Identifier: Apache-2.0
//
// A polygon soup in, a triangle soup over shared vertices out (repair step 1).

#include <algorithm>
#include <limits>

#include "common/geometry/mesh_repair_steps.h"
#include "common/geometry/position_table.h"

namespace tallow {

namespace {

using Polygon = std::vector<std::uint32_t>;

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Copies the used and different vertices; returns the new number of each vertex of the file.
std::vector<std::uint32_t> share_vertices(const PolygonSoup& file, std::vector<Vec3>& vertices,
                                          RepairReport& report) {
    std::vector<bool> used(file.vertices.size(), false);
    for (const Polygon& polygon : file.polygons)
        for (const std::uint32_t v : polygon) used[v] = true;
    std::vector<std::uint32_t> number(file.vertices.size(), kNone);
    vertices.reserve(file.vertices.size());
    PositionTable known(vertices, file.vertices.size());
    for (std::size_t v = 0; v < number.size(); ++v) {
        if (!used[v]) {
            ++report.unused_vertices;
            continue;
        }
        const auto next = static_cast<std::uint32_t>(vertices.size());
        number[v] = known.find_or_enter(file.vertices[v], next);
        if (number[v] == next)
            vertices.push_back(file.vertices[v]);
        else
            ++report.merged_vertices;
    }
    return number;
}

/// Replaces polygons that visit a vertex twice by the loops between the visits.
class CornerMender {
public:
    explicit CornerMender(std::size_t vertices) : place_(vertices, kNone) {}

    /// The loops of three corners or more in `polygon`; itself if no corner repeats.
    std::vector<Polygon> loops(const Polygon& polygon) {
        std::vector<Polygon> result;
        path_.clear();
        for (const std::uint32_t corner : polygon) {
            if (place_[corner] != kNone) cut(place_[corner], result);
            place_[corner] = static_cast<std::uint32_t>(path_.size());
            path_.push_back(corner);
        }
        cut(0, result);
        return result;
    }

private:
    /// Takes path_[first, end) off as a loop of its own.
    void cut(std::uint32_t first, std::vector<Polygon>& result) {
        const auto begin = path_.begin() + first;
        for (auto corner = begin; corner != path_.end(); ++corner) place_[*corner] = kNone;
        if (path_.end() - begin >= 3) result.emplace_back(begin, path_.end());
        path_.erase(begin, path_.end());
    }

    std::vector<std::uint32_t> place_;  // [vertex] where in path_
    Polygon path_;
};

/// Takes polygons one by one, leaves triangles.
class PolygonCutter {
public:
    PolygonCutter(TriangleSoup& soup, bool keep_polygons, RepairReport& report)
        : soup_(soup),
          keep_polygons_(keep_polygons),
          report_(report),
          mender_(soup.vertices.size()) {}

    void add(const Polygon& polygon) {
        cut_or_copy(polygon);
        if (keep_polygons_) soup_.polygon.resize(soup_.triangles.size(), next_);
        ++next_;
    }

private:
    void cut_or_copy(const Polygon& polygon) {
        if (polygon.size() == 3 && polygon[0] != polygon[1] && polygon[1] != polygon[2] &&
            polygon[2] != polygon[0]) {
            soup_.triangles.push_back({polygon[0], polygon[1], polygon[2]});
            return;
        }
        const std::vector<Polygon> loops = mender_.loops(polygon);
        report_.degenerate_faces += loops.size() != 1 || loops[0].size() != polygon.size();
        for (const Polygon& loop : loops) cut(loop);
    }

    /// Cuts a loop from its smallest corner towards the smaller neighbour, so that twins are cut
    /// alike and later steps find them.
    void cut(Polygon loop) {
        if (loop.size() == 3) {
            soup_.triangles.push_back({loop[0], loop[1], loop[2]});
            return;
        }
        ++report_.triangulated_polygons;
        std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
        const bool reversed = loop[1] > loop.back();
        if (reversed) std::reverse(loop.begin() + 1, loop.end());
        const std::size_t first = soup_.triangles.size();
        cut_polygon(soup_.vertices, loop, soup_.triangles);
        for (std::size_t t = first; reversed && t < soup_.triangles.size(); ++t)
            std::swap(soup_.triangles[t][1], soup_.triangles[t][2]);
    }

    TriangleSoup& soup_;
    bool keep_polygons_;
    RepairReport& report_;
    CornerMender mender_;
    std::uint32_t next_ = 0;  // number of the next polygon
};

}  // namespace

TriangleSoup clean_soup(const PolygonSoup& file, RepairReport& report) {
    TriangleSoup soup;
    const std::vector<std::uint32_t> number = share_vertices(file, soup.vertices, report);
    soup.triangles.reserve(file.polygons.size());
    PolygonCutter cutter(soup, !file.uvs.empty(), report);
    Polygon renumbered;
    for (const Polygon& polygon : file.polygons) {
        renumbered.clear();
        for (const std::uint32_t v : polygon) renumbered.push_back(number[v]);
        cutter.add(renumbered);
    }
    return soup;
}

}  // namespace tallow
