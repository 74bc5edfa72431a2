// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "common/base/vec.h"

namespace tallow {

/// The way of light inside a body, from its surface on: straight legs, at whose ends the surface
/// mirrors a part of it.
struct Flight {
    struct Leg {
        Vec3 w{0};         ///< unit
        float length = 0;  ///< mm; infinite if the surface is out of reach
        float share = 0;   ///< of the light that starts on this leg if nothing scatters before
    };
    static constexpr std::size_t kLegs = 3;
    std::array<Leg, kLegs> legs;  // the first one that has no share ends it

    /// That of a half-space.
    static Flight straight(Vec3 w) { return {{Leg{w, kInfinity, 1}}}; }
};

/// Where light on a flight scatters first: with the density e^(-way / mean free path) / mean free
/// path along it, as far as the surface mirrors it back.
class Collisions {
public:
    /// Both lengths in mm.
    Collisions(const Flight& flight, double mean_free_path);

    /// That light scatters before it leaves the body.
    double probability() const { return total_; }

    /// The place behind a share u in [0, 1) of all that scatters, in mm from the start.
    Vec3 at(double u) const;

private:
    const Flight& flight_;
    double mean_free_path_;
    std::array<double, Flight::kLegs> share_{}, until_{};  // [leg] that start on it; that scatter
    double total_ = 0;
};

/// Follows light inside a body from places of its surface [mm], whose normals point outward, along
/// unit directions; what is farther than `longest` mm does not matter.
using FollowFlights =
    std::function<std::vector<Flight>(std::span<const Vec3> from, std::span<const Vec3> normal,
                                      std::span<const Vec3> w, float longest)>;

}  // namespace tallow
