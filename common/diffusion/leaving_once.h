// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.h"
#include "common/diffusion/leaving_radiance.h"
#include "common/diffusion/once_sum.h"
#include "common/nbody/sum_tree.h"
#include "common/optics/diffusion.h"

namespace tallow {

/// A place where light leaves.
struct LeavingPlace {
    Vec3 position;  // on the surface, mm
    Vec3 normal;    // unit, outward
    /// How far the body reaches behind it, by the direction in which light leaves, mm.
    LeavingRadiance reach{kInfinity, Vec3(0)};
};

/// Exitance of light that scattered once and goes straight from there to the surface:
///
///     M_1(x) = alpha' / (4 pi) sum over sources of Phi e^(-d / l) mu T(mu) / d^2
///
/// Phi is the flux that scatters in a source, d its distance, mu the cosine of the way with the
/// normal at x, l the mean free path, and T the transmittance from inside.
///
/// A source stands for the light that entered a cell of the surface: near x it is a disc of that
/// area, parallel to the surface at x.
///
/// Sources beyond the body's reach do not count: they lie across a hollow. The reach is known in a
/// few directions only, so that hollows have to be wider than a quarter of the way to them.
class LeavingOnce {
public:
    /// `sources` must outlive this; `cell_area` [mm^2] is that of their cells in the mean. `part`
    /// [source] is what of their weights is also added up by itself; empty: nothing.
    LeavingOnce(const ReducedChannel& reduced, const SumTree& sources, double cell_area,
                std::span<const float> part = {});

    /// Of all light, and of the part; W/mm^2 if weights are W.
    struct Exitance {
        double all, part;
    };
    /// `near` is room for what is added up, to
    /// be used again.
    Exitance at(const LeavingPlace& place, OnceSources& near) const;

private:
    static constexpr int kHeights = 64;
    static constexpr int kDiscPoints = 16;
    class Gatherer;

    float above_disc(float height) const;
    float part_of(std::uint32_t first, std::uint32_t count) const;

    const SumTree& sources_;
    double factor_;
    float eta_, mean_free_path_, cell_radius_;  // units of the tree
    std::vector<double> part_before_;           // [source], empty without a part
    /// What a disc of the weight 1 does to a place above its middle, by its height in steps of
    /// cell_radius_ / kHeights * kFarFromDisc.
    std::array<float, kHeights + 2> above_disc_;
    std::array<Vec2, kDiscPoints> disc_;  // points of a cell, units of the tree
};

}  // namespace tallow
