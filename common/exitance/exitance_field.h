// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "common/diffusion/cluster_field.h"
#include "common/exitance/control_variate.h"
#include "common/exitance/exitance_kernels.h"
#include "common/exitance/lit_samples.h"
#include "common/exitance/sample_sum.h"

namespace tallow {

/// Where the exitance of a body is asked for.
struct ExitancePoint {
    Vec3 position;    // on the surface, mm
    Vec3 n;           // unit, outward
    Vec3 w_o;         // unit, towards the eye
    Rgb E_direct{0};  // direct light that crosses the surface here, group scales applied, W/mm^2;
                      // only looked at if the field needs_irradiance()
};

/// Exitance at some points, one item a point.
struct Exitance {
    std::vector<Rgb> M;              // W/mm^2
    std::vector<Rgb> bound;          // of |M - plain sum|; empty unless certified
    std::vector<float> evaluations;  // of the kernels, all channels
    std::size_t repeated = 0;        // points and channels that took more than one round
    std::size_t uncertified = 0;     // points and channels whose bound is above the tolerance
};

/// How far the ends of a profile are moved along the surface, mm a channel, times the sine of the
/// direction inside on entry, outside on exit.
struct ExitanceShifts {
    std::array<float, 3> entry{}, exit{};
    bool any() const { return entry != std::array<float, 3>{}; }
};

/// Radiant exitance by multiple scattering on the surface of one body.
///
///     M(x_o) = sum over samples i of R_d(|x_o - x_i|) E_t(x_i) A_i
///
/// Each channel is a scalar sum of its own: kernels differ, and so may positions. Where samples are
/// too far apart for R_d, it is smoothed, and a control variate is added (ExitanceKernels). The
/// accuracy is that of the sums, against the same formula with plain sums: M is 0 where that is
/// below.
/// Source   [JB02] section 3; docs/FINE_MEDIA.md.
class ExitanceField {
public:
    /// The plain sum, for samples that resolve the profiles.
    ExitanceField(const LitSamples& samples, std::array<KernelTable, 3> profiles,
                  ExitanceAccuracy accuracy);

    /// For samples at any distance; `samples` are those of `body` that are lit.
    ExitanceField(const BodyView& body, const LitSamples& samples, const ExitanceKernels& kernels,
                  ExitanceAccuracy accuracy, const ExitanceShifts& shifts = {});

    /// From now on the sums are multiplied by the factor of the body's own diffusion.
    void correct(LeavingField to_body) { to_body_ = std::move(to_body); }

    /// Whether ExitancePoint::E_direct has to be filled.
    bool needs_irradiance() const { return variate_.has_value(); }

    /// Runs on all threads, best for many points at a time; the result does not depend on either.
    Exitance gather(std::span<const ExitancePoint> points) const;

private:
    void add_control_variate(std::span<const ExitancePoint> points, const SumTargets& targets,
                             Exitance& result) const;

    ExitanceAccuracy accuracy_;
    double unit_;
    ExitanceShifts shifts_;
    std::optional<LeavingField> to_body_;
    std::array<std::optional<SampleSum>, 3> sums_;
    std::optional<ControlVariate> variate_;
};

}  // namespace tallow
