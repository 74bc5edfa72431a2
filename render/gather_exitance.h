// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "common/optics/profile_table.h"
#include "render/lit_samples.h"
#include "render/point_sum.h"

namespace tallow {

/// Where the exitance of a body is asked for.
struct ExitancePoint {
    Vec3 position;  // on the surface, mm
    Vec3 n;         // unit, outward
    Vec3 w_o;       // unit, towards the eye
};

/// The kernels of the three channels. Some 20 ms for photon_beam_diffusion, less for the others.
std::array<ProfileTable, 3> tabulate_profiles(Model model, const Medium& medium, Orders orders);

/// Radiant exitance by multiple scattering on the surface of one body.
///
///     M(x_o) = sum over samples i of R_d(|x_o - x_i|) E_t(x_i) A_i
///
/// Each channel is a scalar sum of its own (PointSum): kernels differ, and so may positions.
/// Source   [JB02] section 3.
class ExitanceField {
public:
    /// `tolerance` is the accepted relRMSE of the hierarchy against the plain sum; 0 means the
    /// plain sum. It sets the solid angle of [JB02]; docs/EVALUATOR.md has the measured relation.
    ExitanceField(const LitSamples& samples, std::array<ProfileTable, 3> profiles, float tolerance);

    /// exitance[i] in W/mm^2 at points[i]; neighbours should follow one another. Adds the number
    /// of kernel evaluations (all channels) at each point to evaluations[i]. Thread-safe.
    void gather(std::span<const ExitancePoint> points, std::span<Rgb> exitance,
                std::span<std::uint32_t> evaluations) const;

private:
    std::array<ProfileTable, 3> profiles_;
    std::array<std::unique_ptr<PointSum>, 3> sums_;
    float max_solid_angle_;
};

}  // namespace tallow
