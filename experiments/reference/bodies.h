// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <variant>
#include <vector>

#include "common/scene/scene_geometry.h"
#include "experiments/reference/mesh_body.h"
#include "experiments/reference/sphere_body.h"

namespace tallow::reference {

/// One translucent object.
struct Body {
    std::variant<SphereBody, MeshBody> shape;
    Medium medium;
    std::array<float, 3> reach;  ///< [channel] longest link to the camera that is looked for, mm
    std::uint32_t object;        ///< index into Scene::objects
};

/// How much is prepared before walks begin.
struct Detail {
    /// Longest link, in mean free paths of each channel: longer paths are left to walks from the
    /// camera. Chosen: e^-7 of the light at most, and the fewer beams there are in a cell, the
    /// faster is the search.
    float reach = 7;
    /// Cells around a mesh. Chosen: on the bunny of 40 mm they are 0.34 mm wide, less than a mean
    /// free path of marble.
    double cells = 1e6;
};

/// All of a scene's objects; each of them is a translucent body.
class Bodies {
public:
    /// Throws   InputError for what a walk cannot pass exactly as the scene means it: an opaque
    ///          object, smooth normals, a tinted surface, a shape other than sphere, cube and mesh,
    ///          a squashed sphere, an index below 1, bodies whose boxes of rays overlap, a camera
    ///          inside a body.
    Bodies(const Scene& scene, const SceneGeometry& geometry, const Camera& camera,
           const Detail& detail);

    struct Entry {
        std::uint32_t body;
        Crossing crossing;
    };
    /// Where a ray through the air enters the first body in its way.
    std::optional<Entry> enter(Vec3 origin, Vec3 direction) const;

    /// Whether the path from x inside `body` over a link to the camera is free.
    bool is_clear(std::uint32_t body, Vec3 x, const CameraLink& link) const;

    const Body& operator[](std::uint32_t body) const { return bodies_[body]; }
    std::size_t count() const { return bodies_.size(); }

    /// A ball around all bodies.
    Vec3 center() const { return center_; }
    float radius() const { return radius_; }

private:
    void add(const Scene& scene, const SceneGeometry& geometry, std::uint32_t object,
             const Detail& detail);
    void require_camera_outside(const Scene& scene) const;

    DVec3 camera_;
    std::vector<Body> bodies_;
    Vec3 center_{0};
    float radius_ = 0;
};

}  // namespace tallow::reference
