// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/scene/scene.h"

namespace tallow::reference {

/// The lights of a scene: where walks set out, and what they may end at.
class Lamps {
public:
    /// Light is sent towards the ball around `center`.
    ///
    /// Throws   InputError for a point, spot or directional light: a path over a mirror reflection
    ///          cannot end at it, but in an estimator of its own.
    Lamps(const Scene& scene, Vec3 center, float radius);

    /// Which lamp a walk of a channel starts at, for u in [0, 1), and how probable that is.
    struct Pick {
        std::uint32_t lamp;
        float probability;
    };
    Pick pick(int channel, float u) const;

    /// The start of a walk.
    struct Ray {
        Vec3 origin, direction;
        float power;  ///< W
    };
    /// Light of one lamp and channel on its way to the ball, from a point on the lamp and in a
    /// direction that two pairs in [0, 1)^2 choose evenly. Nothing if it carries none.
    std::optional<Ray> send(std::uint32_t lamp, int channel, Vec2 point, Vec2 direction) const;

    /// Radiance of one channel that arrives against a ray's direction from all lamps that it meets
    /// within `length`, which may be infinite.
    float radiance(int channel, Vec3 origin, Vec3 direction, float length) const;

    std::size_t count() const { return lights_.size(); }

private:
    Vec3 center_;
    float radius_;
    std::vector<Light> lights_;                // scaled with their groups, none switched off
    std::array<std::vector<float>, 3> up_to_;  // [channel][light] part of power up to and with it
};

}  // namespace tallow::reference
