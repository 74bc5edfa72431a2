// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
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

/// Mean free paths along a flight behind which next to no light is left.
inline constexpr double kLongestFlight = 12;

/// Where light on a flight scatters first: with the density e^(-way / mean free path) / mean free
/// path along it, as far as the surface mirrors it back.
class Collisions {
public:
    /// Both lengths in mm.
    Collisions(const Flight& flight, double mean_free_path);

    /// That light scatters before it leaves the body.
    double probability() const { return total_; }

    /// Of the first leg, mean free paths.
    double length() const { return double(flight_.legs[0].length) / mean_free_path_; }

    /// The place behind a share u in [0, 1) of all that scatters, in mm from the start.
    Vec3 at(double u) const;

private:
    const Flight& flight_;
    double mean_free_path_;
    std::array<double, Flight::kLegs> share_{}, until_{};  // [leg] that start on it; that scatter
    double total_ = 0;
};

/// A quadrature of e^-t over a way, t in mean free paths, in a medium whose light decays as
/// e^(-kappa t) deep inside: exact for e^(kappa t), so that the little light which goes deep is
/// right where only that arrives. At kappa = 0 the mean depth is exact.
template <std::size_t N>
struct DecayRule {
    double kappa;
    std::array<double, N> share;   // of what scatters on the way that does so in front of the node;
    std::array<double, N> weight;  // that of the last is for a way without end

    /// The share of node k on a way of `length` mean free paths.
    double share_on(std::size_t k, double length) const;
    /// Node k of a way without end.
    double depth(std::size_t k) const { return -std::log1p(-share[k]); }
};

/// Where on a flight light scatters for the first time, and where on its way out it does so for the
/// last time. Domain: kappa >= 0; 0.95 is taken for larger ones.
DecayRule<5> first_scattering_rule(double kappa);
DecayRule<4> last_scattering_rule(double kappa);

/// Follows light inside a body from places of its surface [mm], whose normals point outward, along
/// unit directions; what is farther than `longest` mm does not matter.
using FollowFlights =
    std::function<std::vector<Flight>(std::span<const Vec3> from, std::span<const Vec3> normal,
                                      std::span<const Vec3> w, float longest)>;

}  // namespace tallow
