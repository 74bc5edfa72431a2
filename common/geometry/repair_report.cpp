// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string_view>

#include "common/geometry/mesh_repair.h"

namespace tallow {

namespace {

/// Collects "dropped 2 unused vertices" and the like, separated by commas.
class Sentence {
public:
    /// Nothing if `count` is 0. `one` is the thing's name; `many` its plural.
    void add(std::string_view did, std::size_t count, std::string_view one, std::string_view many) {
        if (count > 0) add(fmt::format("{} {} {}", did, count, count == 1 ? one : many));
    }
    void add(std::string_view part) {
        if (!text_.empty()) text_ += ", ";
        text_ += part;
    }
    std::string take() { return std::move(text_); }

private:
    std::string text_;
};

}  // namespace

bool RepairReport::changed_anything() const {
    return merged_vertices + unused_vertices + degenerate_faces + duplicate_faces + fin_faces +
               split_vertices + triangulated_polygons + flipped_faces + flipped_components >
           0;
}

std::string RepairReport::summary() const {
    Sentence done;
    done.add("merged", merged_vertices, "vertex", "vertices");
    done.add("dropped", unused_vertices, "unused vertex", "unused vertices");
    done.add("removed", degenerate_faces, "degenerate face", "degenerate faces");
    done.add("dropped", duplicate_faces, "duplicate face", "duplicate faces");
    done.add("dropped", fin_faces, "face of a fin", "faces of fins");
    done.add("split", split_vertices, "non-manifold vertex", "non-manifold vertices");
    done.add("turned", flipped_faces, "face", "faces");
    done.add("turned", flipped_components, "component inside out", "components inside out");
    done.add("cut", triangulated_polygons, "polygon into triangles", "polygons into triangles");
    if (!changed_anything()) done.add("clean");
    if (boundary_loops > 0) done.add("open: " + boundary);
    return done.take();
}

}  // namespace tallow
