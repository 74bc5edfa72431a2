// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "common/exitance/lit_samples.h"
#include "common/nbody/point_sum.h"
#include "common/nbody/solid_angle_sum.h"

namespace tallow {

/// Where the exitance of a body is asked for.
struct ExitancePoint {
    Vec3 position;  // on the surface, mm
    Vec3 n;         // unit, outward
    Vec3 w_o;       // unit, towards the eye
};

/// How far the sum over the samples may be from the plain one.
struct ExitanceAccuracy {
    enum class Criterion {
        error,       ///< PointSum: nodes by the bound of their remainder
        solid_angle  ///< SolidAngleSum: the method of [JB02], for comparison
    };
    /// Accepted relRMSE of the hierarchy; 0 means the plain sum.
    float tolerance = 0.01f;
    Criterion criterion = Criterion::error;
    /// The tolerance is to hold for each point and channel, with proof.
    bool certified = false;
};

/// Exitance at some points, one item a point.
struct Exitance {
    std::vector<Rgb> M;              // W/mm^2
    std::vector<Rgb> bound;          // of |M - plain sum|; empty unless certified
    std::vector<float> evaluations;  // of the kernels, all channels
    std::size_t repeated = 0;        // points and channels that took more than one round
    std::size_t uncertified = 0;     // points and channels whose bound is above the tolerance
};

/// The kernels of the three channels, in a common unit. Some 30 ms for photon_beam_diffusion, less
/// for the others.
std::array<KernelTable, 3> tabulate_profiles(Model model, const Medium& medium, Orders orders);

/// Radiant exitance by multiple scattering on the surface of one body.
///
///     M(x_o) = sum over samples i of R_d(|x_o - x_i|) E_t(x_i) A_i
///
/// Each channel is a scalar sum of its own: kernels differ, and so may positions.
/// Source   [JB02] section 3.
class ExitanceField {
public:
    ExitanceField(const LitSamples& samples, std::array<KernelTable, 3> profiles,
                  ExitanceAccuracy accuracy);

    /// Runs on all threads, best for many points at a time; the result does not depend on either.
    Exitance gather(std::span<const ExitancePoint> points) const;

private:
    void gather_by_error(std::span<const ExitancePoint> points, Exitance& result) const;
    void gather_by_solid_angle(std::span<const ExitancePoint> points, Exitance& result) const;

    ExitanceAccuracy accuracy_;
    std::array<KernelTable, 3> profiles_;
    // Of these one kind is made, as the accuracy asks for.
    std::array<std::unique_ptr<PointSum>, 3> sums_;
    std::array<std::unique_ptr<SolidAngleSum>, 3> solid_angle_sums_;
};

}  // namespace tallow
