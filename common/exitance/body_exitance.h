// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/base/plan.h"
#include "common/diffusion/body_diffusion.h"
#include "common/exitance/exitance_field.h"
#include "common/scene/scene.h"

namespace tallow {

/// Where exitance is wanted: at points that are seen, whose irradiance can be gathered, or where
/// paths of indirect light end.
enum class ExitanceUse { seen, paths };

/// How well diffusion in a body is to be resolved: as the tolerance asks for, or, if it is not 0,
/// on about `clusters` clusters.
struct DiffusionWish {
    double tolerance = 0.01;
    std::size_t clusters = 0;
};

/// What became of a solve.
struct DiffusionReport {
    bool wanted = false;       ///< a finite body of a material with boundary elements
    std::size_t clusters = 0;  ///< 0: nothing was solved
    std::array<bool, 3> solved{};
    int iterations = 0;
    bool converged = true;
    double error = 0;  ///< estimated relRMSE of the exitance; see BodyDiffusion::estimate_error()
};

/// Takes over what is worse in `b`.
void add_worse(DiffusionReport& report, const DiffusionReport& b);

/// What people are to know of it, without an end of line: that GMRES did not converge, or that the
/// error is more than kMostOfTolerance times the tolerance. Empty if all is well.
std::string diffusion_warning(const DiffusionReport& report, double tolerance);

/// Which channels of an object are solved on how many clusters, and which are not, and why; empty
/// if no solve was wanted.
std::vector<Decision> diffusion_decisions(std::size_t object, const DiffusionReport& report);

/// Clusters are chosen for a given cost; where they miss the tolerance by less nobody is told.
inline constexpr double kMostOfTolerance = 2;

/// What the exitance of one body is made of beside its light: kernels for its medium and spacing,
/// and, for a body-aware material, diffusion in the body. Made once; the light may change after.
///
/// Source   docs/FINE_MEDIA.md, docs/BODY_AWARE.md.
class BodyExitance {
public:
    /// `body` must outlive this and its fields. A plane has no diffusion of its own: it is the
    /// half-space that the profile stands for. Channels are solved whose mean free path the samples
    /// resolve. `follow` traces light inside the body.
    BodyExitance(const BodyView& body, const Scene& scene, Orders orders, ExitanceUse use,
                 FollowFlights follow, DiffusionWish wish = {});

    /// Clusters on which diffusion is solved; 0 if it is not.
    std::size_t clusters() const { return diffusion_ ? diffusion_->clusters().count() : 0; }
    /// The tree that the clusters are cut from, of all samples; null without clusters.
    const PatchTree* tree() const { return diffusion_ ? &diffusion_->tree() : nullptr; }
    std::size_t memory_bytes() const { return diffusion_ ? diffusion_->memory_bytes() : 0; }

    /// By what the irradiance of indirect light is to be multiplied, for single scattering of it is
    /// not marched: 1 where solve() adds what of it leaves after one scattering, the ratio of the
    /// profile's total reflectances where it stands alone.
    Rgb indirect_gain() const;

    /// Diffusion of some light. Solutions of several lights may be added. Empty if there are no
    /// clusters.
    BodyDiffusion::Solution solve(const LitSamples& lit) const;

    DiffusionReport report(const BodyDiffusion::Solution& solution) const;

    /// The exitance under some light, of which `solution` is the diffusion; that of the half-space
    /// if it is empty.
    ExitanceField field(const LitSamples& lit, const BodyDiffusion::Solution& solution,
                        ExitanceAccuracy accuracy) const;

private:
    std::vector<Rgb> first_order(const LitSamples& lit) const;
    std::vector<Rgb> at_clusters(const ExitanceField& field) const;

    const BodyView& body_;
    ExitanceUse use_;
    Medium medium_;
    Orders orders_;
    Rgb profile_gain_;  // of indirect light, where the profile stands alone
    // What of the first order the profile of two orders and more does not hold, and that profile
    // where kernels_ are of all orders.
    Rgb first_order_;
    std::optional<ExitanceKernels> two_and_more_;
    bool directional_ = false;
    std::optional<ExitanceKernels> kernels_;
    ExitanceShifts shifts_;
    Rgb strength_;  // of the body's diffusion
    bool wants_diffusion_;
    FollowFlights follow_;
    std::optional<BodyDiffusion> diffusion_;
};

}  // namespace tallow
