// SPDX-License-Identifier: Apache-2.0
#include "common/optics/profile.h"

#include "common/base/check.h"
#include "common/optics/dipole.h"
#include "common/optics/profile_models.h"

namespace tallow {
namespace {

// A channel that does not scatter sends nothing back.
class BlackProfile final : public Profile {
public:
    double operator()(double) const override { return 0; }
    double total_reflectance() const override { return 0; }
};

}  // namespace

std::unique_ptr<Profile> make_profile(Model model, const Medium& medium, int channel,
                                      Orders orders) {
    const ReducedChannel reduced = reduced_channel(medium, channel);
    if (reduced.alpha_prime == 0) return std::make_unique<BlackProfile>();
    switch (model) {
        case Model::dipole:
            return dipole_profile(medium, channel, mismatch_A(medium.eta));
        case Model::classic_dipole:
            return dipole_profile(medium, channel, classic_mismatch_A(medium.eta));
        case Model::better_dipole:
            return better_dipole_profile(reduced);
        case Model::normalized_diffusion:
            return normalized_diffusion_profile(reduced);
        case Model::photon_beam_diffusion:
            return photon_beam_diffusion_profile(reduced);
        case Model::transport:
        case Model::body_aware:  // what differs is what is done with it
            return transport_profile(reduced, orders);
    }
    TALLOW_CHECK(false, "model {}", int(model));
}

}  // namespace tallow
