// SPDX-License-Identifier: Apache-2.0
// Which part of a profile its samples cannot resolve, and what is done about it.
#include "common/exitance/exitance_kernels.h"

#include <algorithm>
#include <optional>

#include "common/base/parallel.h"
#include "common/exitance/smoothed_profile.h"
#include "common/optics/single_scattering.h"

namespace tallow {
namespace {

// Standard deviations of g in spacings: with the control variate, and without it, where g is
// sharpened. Chosen on planes of bisected and of clustered cells and on scenes: of the first, 0.6
// and 0.8 raise or halve the noise and change the error of shadow edges by a tenth to a fifth.
constexpr double kCorrected = 0.7, kSharpened = 1.0;

// How much lower R is in its centre after smoothing, 1 - (R * g)(0) / R(0), over which smoothing
// comes in. Below the first, R is so smooth that its plain sum has less noise than smoothing would
// blur (the dipole has 0.1 at 0.35 mean free paths, and 0.2 % noise under uniform light; at 1 it
// has 0.5 and 2 %). Fitted to 64 edges of the light across irregular cells, the dipole at 0.5
// to 1.5 mean free paths: RMS error 1.00, 1.00, 0.94 (at 0.85), 1.00 (at 1), 0.98, 0.64 of the
// plain sum's, where 0.15 to 0.4 has 1.075 at 1 and 0.4 to 0.8 has 0.96, but 1.7 times the noise
// under uniform light. Profiles that grow as 1/r or -ln r are above the second.
constexpr double kSmoothFrom = 0.25, kSmoothTo = 0.6;

// Share beta / R_total over which g loses its sharpening and the control variate comes in. Chosen:
// it takes shadow rays at every shading point, and R * g must not have a negative rim when R is
// narrow. At the default spacing, 0.35 mean free paths, the dipoles, photon beam diffusion and
// `transport` beside single scattering have at most 0.074 at any albedo; the 1/r of the first order
// (`transport` alone, normalized diffusion) has 0.03 to 0.09 above an albedo of 0.97, 0.14 at 0.9.
constexpr double kPlainFrom = 0.06, kCorrectFrom = 0.12, kCorrectTo = 0.24;

// Less smoothing than this part of the spacing does nothing.
constexpr double kLeastSmoothing = 0.05;

double smooth_step(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// What becomes of one channel.
struct Treatment {
    Smoothing smoothing{0};
    double beta = 0, kappa = 0;
};

Treatment treat(const Profile& profile, double mean_free_path, double spacing) {
    if (profile.total_reflectance() == 0) return {};
    const double corrected = kCorrected * spacing;
    const NearbyParts parts = nearby_parts(profile, mean_free_path, corrected);
    const double share = parts.beta / profile.total_reflectance();
    const double used = smooth_step(kCorrectFrom, kCorrectTo, share);
    const double t = 1 - smooth_step(kPlainFrom, kCorrectFrom, share);
    const double sigma = (kCorrected + t * (kSharpened - kCorrected)) * spacing *
                         smooth_step(kSmoothFrom, kSmoothTo, 1 - parts.centre / profile(0));
    return {{sigma, t}, used * parts.beta, used * parts.kappa};
}

/// (1 - weight) a + weight b.
class BlendedProfile : public Profile {
public:
    BlendedProfile(std::unique_ptr<Profile> a, std::unique_ptr<Profile> b, double weight)
        : a_(std::move(a)), b_(std::move(b)), weight_(weight) {}
    double operator()(double r2) const override {
        return (1 - weight_) * (*a_)(r2) + weight_ * (*b_)(r2);
    }
    double total_reflectance() const override {
        return (1 - weight_) * a_->total_reflectance() + weight_ * b_->total_reflectance();
    }

private:
    std::unique_ptr<Profile> a_, b_;
    double weight_;
};

}  // namespace

double first_order_marched(const Medium& medium, int channel) {
    if (medium.g <= 0) return 1;
    const double eta = double(medium.eta);
    const double reduced =
        single_scattering_reflectance(double(medium.alpha_prime()[channel]), eta);
    if (reduced == 0) return 1;
    return std::min(1.0, single_scattering_reflectance(double(medium.albedo()[channel]), eta,
                                                       double(medium.g)) /
                             reduced);
}

std::unique_ptr<Profile> make_exitance_profile(Model model, const Medium& medium, int channel,
                                               Orders orders) {
    auto profile = make_profile(model, medium, channel, orders);
    const bool knows_orders = model == Model::transport || model == Model::body_aware;
    if (!knows_orders || orders == Orders::all) return profile;
    const double s = first_order_marched(medium, channel);
    if (s == 1) return profile;
    return std::make_unique<BlendedProfile>(make_profile(model, medium, channel, Orders::all),
                                            std::move(profile), s);
}

ExitanceKernels make_exitance_kernels(Model model, const Medium& medium, Orders orders,
                                      double spacing_mm) {
    const Rgb scale = medium.mean_free_path();
    std::array<std::unique_ptr<Profile>, 3> profiles;
    std::array<double, 3> scales{}, beta{}, kappa{};
    std::array<bool, 3> smoothed{};
    parallel_for(3, 1, [&](std::size_t c) {
        profiles[c] = make_exitance_profile(model, medium, int(c), orders);
        scales[c] = scale[int(c)];
        const Treatment treatment = treat(*profiles[c], scales[c], spacing_mm);
        beta[c] = treatment.beta, kappa[c] = treatment.kappa;
        if (treatment.smoothing.sigma < kLeastSmoothing * spacing_mm) return;
        profiles[c] =
            std::make_unique<SmoothedProfile>(*profiles[c], scales[c], treatment.smoothing);
        scales[c] = std::max(scales[c], treatment.smoothing.sigma);
        smoothed[c] = true;
    });
    const double unit = KernelTable::unit_near((scales[0] + scales[1] + scales[2]) / 3);
    std::array<std::optional<KernelTable>, 3> tables;
    parallel_for(3, 1, [&](std::size_t c) { tables[c] = tabulate(*profiles[c], scales[c], unit); });
    return {{*tables[0], *tables[1], *tables[2]},
            beta,
            kappa,
            kCorrected * spacing_mm,
            smoothed[0] || smoothed[1] || smoothed[2]};
}

std::array<KernelTable, 3> tabulate_profiles(Model model, const Medium& medium, Orders orders) {
    const Rgb scale = medium.mean_free_path();
    const double unit = KernelTable::unit_near(mean(scale));
    const auto table = [&](int channel) {
        return tabulate(*make_profile(model, medium, channel, orders), scale[channel], unit);
    };
    return {table(0), table(1), table(2)};
}

}  // namespace tallow
