// SPDX-License-Identifier: Apache-2.0
// The standard dipole of dipole.h as a profile, in double; `dipole` and `classic-dipole` differ in
// the boundary's A only.
#include "common/optics/dipole.h"
#include "common/optics/profile_models.h"

namespace tallow {
namespace {

class DipoleProfile final : public Profile {
public:
    explicit DipoleProfile(const DipoleChannel<double>& dipole) : dipole_(dipole) {}
    double operator()(double r2) const override { return diffuse_reflectance(dipole_, r2); }
    double total_reflectance() const override { return tallow::total_reflectance(dipole_); }

private:
    DipoleChannel<double> dipole_;
};

}  // namespace

std::unique_ptr<Profile> dipole_profile(const Medium& medium, int channel, double A) {
    return std::make_unique<DipoleProfile>(dipole_channel<double>(medium, channel, A));
}

}  // namespace tallow
