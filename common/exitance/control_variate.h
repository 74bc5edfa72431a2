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
/// points themselves. For each channel, with g the Gaussian and beta of ExitanceKernels,
///
///     C(x) = beta (E(x) - sum_j A_j E_j g(|x - x_j|))
///          + beta (1 - beta / R_total) E(x) max(-1, 1 - sum_j A_j g(|x - x_j|))
///
/// The first line moves beta of the profile from the neighbourhood to the point. The second is the
/// control variate: on a plane without sampling noise the sum over the areas is 1, so that its
/// deviation from 1 tells how noisy the sum is here, or that it reaches over an edge which light
/// does not see; the remaining R_total - beta is corrected by that, in the share beta / R_total in
/// which it comes from nearby. Uniform light on a plane keeps (1 - beta / R_total)^2 of its noise.
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

    std::array<double, 3> beta_, rest_;                // rest is beta (1 - beta / R_total)
    std::array<std::optional<SampleSum>, 3> blurred_;  // of A E; none where beta is 0
    SampleSum mass_;                                   // of A
};

}  // namespace tallow
