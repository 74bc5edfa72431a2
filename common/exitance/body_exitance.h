// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "common/diffusion/body_diffusion.h"
#include "common/exitance/exitance_field.h"
#include "common/scene/scene.h"

namespace tallow {

/// Where exitance is wanted: at points that are seen, whose irradiance can be gathered, or where
/// paths of indirect light end.
enum class ExitanceUse { seen, paths };

/// What the exitance of one body is made of beside its light: kernels for its medium and spacing,
/// and, for a body-aware material, diffusion in the body. Made once; the light may change after.
///
/// Source   docs/FINE_MEDIA.md, docs/BODY_AWARE.md.
class BodyExitance {
public:
    /// `body` must outlive this and its fields. A plane has no diffusion of its own: it is the
    /// half-space that the profile stands for. `clusters` is 0 for as many as the body needs.
    BodyExitance(const BodyView& body, const Scene& scene, Orders orders, ExitanceUse use,
                 std::size_t clusters = 0);

    /// Clusters on which diffusion is solved; 0 if it is not.
    std::size_t clusters() const { return diffusion_ ? diffusion_->clusters().count() : 0; }
    std::size_t memory_bytes() const { return diffusion_ ? diffusion_->memory_bytes() : 0; }

    /// How far beams of light are to be followed for solve(), mm; 0 if they are not asked for.
    float beam_length() const { return beam_length_; }

    /// Diffusion of some light, which goes the ways of beams[sample] before it scatters. Solutions
    /// of several lights may be added. Empty if there are no clusters.
    BodyDiffusion::Solution solve(const LitSamples& lit, std::span<const Beam> beams) const;

    /// BodyDiffusion::estimate_error(); 0 if there are no clusters.
    double estimate_error(const BodyDiffusion::Solution& solution) const;

    /// The exitance under some light, of which `solution` is the diffusion; that of the half-space
    /// if it is empty.
    ExitanceField field(const LitSamples& lit, const BodyDiffusion::Solution& solution,
                        ExitanceAccuracy accuracy) const;

private:
    const BodyView& body_;
    ExitanceUse use_;
    std::optional<ExitanceKernels> kernels_;
    ExitanceShifts shifts_;
    Rgb strength_;  // of the body's diffusion
    std::optional<BodyDiffusion> diffusion_;
    float beam_length_ = 0;
};

}  // namespace tallow
