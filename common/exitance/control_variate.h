// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>

#include "common/cloud/cache_io.h"
#include "common/exitance/exitance_kernels.h"
#include "common/exitance/lit_samples.h"
#include "common/exitance/sample_sum.h"

namespace tallow {

/// What smoothed kernels have blurred, put back from the direct irradiance E(x) at the shading
/// points themselves. For each channel, with g the Gaussian, beta and kappa of ExitanceKernels,
///
///     C(x) = beta (E(x) - sum_j A_j E_j g(|x - x_j|))
///          + (kappa - beta) E(x) max(-1, 1 - sum_j A_j g(|x - x_j|))
///
/// The first line moves beta of the profile from the neighbourhood to the point. The second is a
/// control variate for the noise: on a plane of evenly spread samples the sum over the areas is 1,
/// so that its deviation tells how far off the sums with g are here, or that they reach around an
/// edge of the surface which the profile is too narrow to see.
///
/// Only direct irradiance is known at x. Indirect light is smooth: it stays in the smoothed sum.
/// Source   derived and measured in docs/FINE_MEDIA.md.
class ControlVariate {
public:
    ControlVariate(const BodyView& body, const LitSamples& lit, const ExitanceKernels& kernels,
                   const ExitanceAccuracy& accuracy);

    /// One channel of C at the targets, and for certified sums a bound of its error and the
    /// evaluations of the kernel.
    struct Result {
        std::array<std::vector<float>, 3> C;      // [channel][target] W/mm^2
        std::array<std::vector<float>, 3> bound;  // the same; certified only
        std::vector<float> evaluations;           // [target]
    };
    /// E[target] is the direct irradiance there, group scales applied.
    Result evaluate(const SumTargets& targets, std::span<const Rgb> E) const;

private:
    void add_channel(std::size_t channel, const SumTargets& targets, std::span<const Rgb> E,
                     const SampleSum::Result& mass, Result& result) const;

    std::array<double, 3> beta_, rest_;                // rest is kappa - beta
    std::array<std::optional<SampleSum>, 3> blurred_;  // of A E; none where beta is 0
    SampleSum mass_;                                   // of A
};

}  // namespace tallow
