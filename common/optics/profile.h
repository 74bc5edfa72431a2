// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "common/optics/medium.h"

namespace tallow {

/// Models of the multiple scattering of a half-space; docs/PHYSICS.md says which to use when.
enum class Model {
    dipole,                 ///< [JMLH01] eq. 4, F_dr by quadrature
    classic_dipole,         ///< the same with the polynomial fit of F_dr that the papers print
    better_dipole,          ///< [d'Eon12]
    normalized_diffusion,   ///< [CB15]
    photon_beam_diffusion,  ///< [HCJ13], orders >= 2
    transport,              ///< the half-space itself, by random walks
    body_aware              ///< transport, corrected to the body by its own diffusion
};

/// Names as scene files spell them: "dipole", "classic-dipole", "better-dipole", ...
inline constexpr std::array<std::pair<std::string_view, Model>, 7> kModels = {{
    {"dipole", Model::dipole},
    {"classic-dipole", Model::classic_dipole},
    {"better-dipole", Model::better_dipole},
    {"normalized-diffusion", Model::normalized_diffusion},
    {"photon-beam-diffusion", Model::photon_beam_diffusion},
    {"transport", Model::transport},
    {"body-aware", Model::body_aware},
}};

/// Radial profile of the light that leaves a half-space around the point where it entered, in one
/// channel, as a function of the squared distance.
///
/// Units    r2 [mm^2] -> R [1/mm^2].
/// Domain   r2 >= 0 and finite; R is finite, >= 0 and falls monotonically, at r2 = 0 too. Towards
///          r = 0 normalized diffusion and the first order of `transport` go as 1/r, photon beam
///          diffusion and the other orders as -ln r: all four are softened inside 1e-3 mean free
///          paths, see profile_models.h.
class Profile {
public:
    virtual ~Profile() = default;
    virtual double operator()(double r2) const = 0;
    /// Integral over the plane: 2 pi * integral of R r dr.
    virtual double total_reflectance() const = 0;
};

/// Which scattering orders a profile must hold so that nothing is counted twice. Only `transport`
/// and
/// `body_aware` can tell them apart; photon_beam_diffusion always holds the orders >= 2; the others
/// hold what their authors put in.
enum class Orders { all, two_and_more };

/// The profile of channel `channel` of a medium.
///
/// Throws   InputError for `transport` and `normalized_diffusion`, which takes its total from it,
/// if
///          the index is outside of the transport table, [0.7, 3].
std::unique_ptr<Profile> make_profile(Model model, const Medium& medium, int channel,
                                      Orders orders);

}  // namespace tallow
