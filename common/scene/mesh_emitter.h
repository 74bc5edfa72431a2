// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry/ray_scene.h"

namespace tallow {

/// A mesh that shines from the outer side of its triangles. It is opaque to its own light.
class MeshEmitter {
public:
    /// `mesh` in world space, mm. `repair` says what was wrong with its file, or nothing.
    /// Throws InputError if no triangle has an area.
    explicit MeshEmitter(TriangleMesh mesh, std::string repair = {});

    struct Point {
        Vec3 position;
        Vec3 normal;  // unit, outward
    };
    /// Uniform over the area; neighbouring u.x lie on triangles that are neighbours in the file.
    Point draw(Vec2 u) const;

    /// The first side that the ray meets, if that is an outer one.
    struct Crossing {
        float t;      // mm
        Vec3 normal;  // unit, outward
    };
    std::optional<Crossing> cross(const Ray& ray) const;

    /// Whether the mesh hides `point` from somebody `distance` away in unit direction w.
    bool hides(const Point& point, Vec3 w, float distance) const;

    float area() const { return area_; }  ///< mm^2
    Box box() const { return bounding_box(surfaces_[0]); }
    std::uint64_t hash() const;  ///< XXH3 of vertices and triangles
    const std::string& repair() const { return repair_; }

private:
    const TriangleMesh& mesh() const { return std::get<TriangleMesh>(surfaces_[0]); }

    std::vector<double> end_;  // [triangle] part of the area up to and with this one
    float area_;
    std::vector<Surface> surfaces_;  // one
    RayScene rays_;
    std::string repair_;
};

}  // namespace tallow
