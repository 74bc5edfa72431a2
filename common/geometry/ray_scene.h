// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "common/base/vec.h"
#include "common/geometry/surface.h"

namespace tallow {

/// Where a ray meets a surface.
struct Hit {
    float t;               ///< distance along the ray, mm
    std::uint32_t object;  ///< index of the surface
    Vec3 position;         ///< on the surface, mm
    Vec3 n_g;              ///< geometric normal, unit, outward
    Vec3 n;                ///< shading normal, unit, outward
    Vec2 uv{0};            ///< texture coordinates: the mesh's (0 without), sphere_uv() and so on
};

/// A segment to be tested for what is in its way.
struct ShadowRay {
    Vec3 origin;
    Vec3 direction;  // unit
    float length;    // mm; infinite for a light at infinity
};

/// All surfaces of a scene, ready for ray queries from any thread. The only user of Embree.
class RayScene {
public:
    /// `surfaces` must outlive the scene; the index in it is Hit::object.
    explicit RayScene(std::span<const Surface> surfaces);
    ~RayScene();
    RayScene(RayScene&&) noexcept;
    RayScene& operator=(RayScene&&) noexcept;

    /// Nearest hit in (0, length].
    std::optional<Hit> intersect(const Ray& ray, float length = kInfinity) const;

    /// The same for many rays, in packets; faster where they start together and run side by side.
    /// Of triangles that meet in one edge or point another one may be found.
    void intersect(std::span<const Ray> rays, std::span<std::optional<Hit>> result) const;

    /// Nearest hit with one surface only: where a ray inside a body leaves it.
    std::optional<Hit> intersect_object(const Ray& ray, std::uint32_t object,
                                        float length = kInfinity) const;

    /// The same for many rays; faster where neighbours are similar.
    void intersect_object(std::span<const ShadowRay> rays, std::uint32_t object,
                          std::span<std::optional<Hit>> result) const;

    /// Start of a ray that leaves the surface at `position` towards the side of `direction`: moved
    /// along the geometric normal by 2^-15 of the largest coordinate (256 units in the last place),
    /// or, near the origin, of 1/64 of the scene's. Small against the scene at any scale of it.
    ///
    /// Source   Wächter, Binder 2019, "A Fast and Robust Method for Avoiding Self-Intersection",
    ///          for the number of units; their absolute step near the origin is replaced.
    Vec3 offset_origin(Vec3 position, Vec3 n_g, Vec3 direction) const;

    bool occluded(const ShadowRay& ray) const;

    /// occluded() for many rays; faster where neighbours are similar.
    void occluded(std::span<const ShadowRay> rays, std::span<bool> result) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace tallow
