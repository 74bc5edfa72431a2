// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "common/optics/diffusion.h"
#include "common/optics/profile.h"

namespace tallow {

/// A profile written in reduced mean free paths. Lengths scale by sigma_t', so that
/// R(r) = sigma_t'^2 * reduced(r sigma_t').
class ReducedProfile : public Profile {
public:
    explicit ReducedProfile(double sigma_t_prime) : sigma2_(sigma_t_prime * sigma_t_prime) {}
    double operator()(double r2) const final { return sigma2_ * reduced(r2 * sigma2_); }

protected:
    /// r2 in mean free paths^2, the result per mean free path^2.
    virtual double reduced(double r2) const = 0;

private:
    double sigma2_;
};

/// Profiles that grow without bound towards their centre, as 1/r or -ln r, are evaluated at
/// softened(r2) = sqrt(r2 + kInnermost^2) in place of r: flat inside 1e-3 mean free paths, and
/// still smooth. Their plane integral is then that of the unsoftened profile outside of kInnermost.
inline constexpr double kInnermost = 1e-3;
inline double softened(double r2) { return std::sqrt(r2 + kInnermost * kInnermost); }

// One function a model; make_profile() chooses. profile.h names the sources.
std::unique_ptr<Profile> dipole_profile(const Medium& medium, int channel, double A);
std::unique_ptr<Profile> better_dipole_profile(const ReducedChannel& channel);
std::unique_ptr<Profile> normalized_diffusion_profile(const ReducedChannel& channel);
std::unique_ptr<Profile> photon_beam_diffusion_profile(const ReducedChannel& channel);
std::unique_ptr<Profile> transport_profile(const ReducedChannel& channel, Orders orders);

}  // namespace tallow
