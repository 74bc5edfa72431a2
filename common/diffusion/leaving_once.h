// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "common/base/vec.h"
#include "common/diffusion/once_sum.h"
#include "common/nbody/sum_tree.h"
#include "common/optics/diffusion.h"

namespace tallow {

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
/// Domain   distances are straight, also across hollows.
class LeavingOnce {
public:
    /// `sources` must outlive this; `cell_area` [mm^2] is that of their cells in the mean.
    LeavingOnce(const ReducedChannel& reduced, const SumTree& sources, double cell_area);

    /// At a place of the surface [mm] with its unit normal; W/mm^2 if weights are W. `near` is room
    /// for what is added up, to be used again.
    double at(Vec3 place, Vec3 normal, OnceSources& near) const;

private:
    static constexpr int kHeights = 64;
    static constexpr int kDiscPoints = 16;
    class Gatherer;

    float above_disc(float height) const;

    const SumTree& sources_;
    double factor_;
    float eta_, mean_free_path_, cell_radius_;  // units of the tree
    /// What a disc of the weight 1 does to a place above its middle, by its height in steps of
    /// cell_radius_ / kHeights * kFarFromDisc.
    std::array<float, kHeights + 2> above_disc_;
    std::array<Vec2, kDiscPoints> disc_;  // points of a cell, units of the tree
};

}  // namespace tallow
