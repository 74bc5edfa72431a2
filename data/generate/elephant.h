// SPDX-License-Identifier: Apache-2.0
//
// An elephant calf, seated, in the manner of a carved stone figure.
#pragma once

#include "sdf.h"

#include <vector>

namespace tallow::sculpt {

/// The sculpture as a signed distance function.
///
/// Units    mm. 43 tall to the tip of the trunk, 38 to the crown; y is up, the ground is y = 0,
///          the calf faces +z, its left is +x.
/// Error    a distance only roughly, and only near the surface: its gradient there has a length
///          near 1, but of 0.1 to 5 in the sharpest creases. The sign is what counts.
class Elephant {
public:
    Elephant();

    /// Negative inside, zero on the surface, positive outside.
    double distance(Vec p) const;

    /// Outward unit normal, from central differences of `distance`.
    Vec normal(Vec p) const;

private:
    struct Foot {
        Frame frame;  // z out through the sole, y towards the middle toe
        double radius, half_height;
        double toe_spread_rad, toe_tilt_rad;  // from toe to toe; of the nails towards the sole
        int toes;
    };

    Vec on_surface(Vec p) const;
    void place_legs(double side);
    void place_ear(double side, double swept_back_rad, double raised_rad);
    void place_eye(double side);
    void engrave(const Frame& frame, const std::vector<Vec>& chain, double width, double depth);
    void engrave_skin();

    double body(Vec p) const;
    double add_foot(double d, const Foot& foot, Vec p) const;
    double add_tail(double d, Vec p) const;
    double add_skull(double d, Vec h) const;
    double add_trunk(double d, Vec h) const;
    double add_ear(double d, const Frame& frame, Vec h) const;
    double add_eye(double d, const Frame& frame, Vec p) const;

    Frame head_;  // origin in the middle of the skull, y up, z forward; points in it are called h
    Limb tail_, trunk_;
    Outline ear_outline_;
    std::vector<Limb> ear_veins_;  // in ear coordinates, z = 0
    std::vector<Frame> ears_;      // in head coordinates: x outwards, y up, z forward
    std::vector<Limb> legs_;
    std::vector<Foot> feet_;
    std::vector<Frame> eyes_;  // z out of the head, y up
    std::vector<Groove> grooves_;
};

}  // namespace tallow::sculpt
