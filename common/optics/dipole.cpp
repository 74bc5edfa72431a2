// SPDX-License-Identifier: Apache-2.0
#include "common/optics/dipole.h"

#include "common/optics/fresnel.h"

namespace tallow {

double mismatch_A(double eta) {
    const double F_dr = diffuse_fresnel_reflectance(eta);
    return (1 + F_dr) / (1 - F_dr);
}

}  // namespace tallow
