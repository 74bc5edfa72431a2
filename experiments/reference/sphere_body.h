// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "common/base/vec.h"
#include "experiments/reference/crossing.h"

namespace tallow::reference {

/// A sphere filled with a medium, as walks and a fixed camera see it.
class SphereBody {
public:
    /// `eta` inside / outside; `camera` outside.
    SphereBody(Vec3 center, float radius, double eta, DVec3 camera)
        : center_(center), radius_(radius), eta_(eta), camera_(camera) {}

    /// Whether links() reports every path that is refracted once and not longer than `reach`.
    static constexpr bool kLinksAll = false;

    bool holds(Vec3 x) const { return glm::length(DVec3(x) - center_) < radius_; }

    /// Where a ray from outside enters, nothing if beyond `length` or missed.
    std::optional<Crossing> enter(Vec3 origin, Vec3 direction, float length) const;
    /// Where a ray from inside leaves, nothing if beyond `length`.
    std::optional<Crossing> leave(Vec3 origin, Vec3 direction, float length) const;

    /// Lower bound of the distance from an inner point to the surface; < 0 for a point outside.
    float clearance(Vec3 x) const;

    /// Calls use(const CameraLink&) for at most one link from x: see links_path().
    template <class Use>
    void links(Vec3 x, float reach, Use&& use) const {
        if (const std::optional<CameraLink> link = find_link(x, reach)) use(*link);
    }

    /// Whether links() from x reports the path through p, `inside` long: of all paths through the
    /// sphere the one that the search ends at, if it is shorter than `reach` and not near a
    /// caustic.
    bool links_path(Vec3 x, Vec3 p, float inside, float reach) const;

    /// Whether the body itself leaves the path open: always.
    bool is_clear(Vec3, const CameraLink&) const { return true; }

    Vec3 center() const { return Vec3(center_); }
    float radius() const { return float(radius_); }

private:
    std::optional<CameraLink> find_link(Vec3 x, float reach) const;
    Crossing crossing(Vec3 origin, Vec3 direction, double t) const;

    DVec3 center_;
    double radius_;
    double eta_;
    DVec3 camera_;
};

}  // namespace tallow::reference
