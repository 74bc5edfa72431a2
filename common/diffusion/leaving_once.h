// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

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
    Exitance at(const LeavingPlace& place, OnceSources& room) const;

private:
    OnceCloud cloud_;
    double factor_;
};

}  // namespace tallow
