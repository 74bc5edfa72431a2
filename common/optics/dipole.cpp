// SPDX-License-Identifier: Apache-2.0
#include "common/optics/dipole.h"

#include "common/base/check.h"
#include "common/optics/fresnel.h"

namespace tallow {

double mismatch_A(double eta) {
    const double F_dr = diffuse_fresnel_reflectance(eta);
    return (1 + F_dr) / (1 - F_dr);
}

double classic_mismatch_A(double eta) {
    const double x = 1 / eta;
    const double F_dr = eta < 1 ? -0.4399 + x * (0.7099 + x * (-0.3319 + x * 0.0636))
                                : 0.668 + 0.0636 * eta + x * (0.710 - x * 1.440);
    TALLOW_CHECK(F_dr > -1 && F_dr < 1, "F_dr {} of the polynomial at eta {}", F_dr, eta);
    return (1 + F_dr) / (1 - F_dr);
}

}  // namespace tallow
