// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "common/optics/medium.h"

namespace tallow {

/// One channel of the standard dipole. F is float in kernels and double in references.
template <class F>
struct DipoleChannel {
    F alpha_prime;  ///< reduced albedo
    F sigma_tr;     ///< effective transport coefficient, 1/mm
    F z_r, z_v;     ///< depth of the real source, height of the virtual one, mm, both > 0
};

/// Constants of the standard dipole in channel `c` of a medium.
///
///     z_r = 1 / sigma_t',   z_v = z_r (1 + 4 A / 3),   A = (1 + F_dr) / (1 - F_dr)
///
/// `A` comes from quadrature of the Fresnel equations: mismatch_A(medium.eta).
/// Source   [JMLH01] eq. 4.
template <class F>
DipoleChannel<F> dipole_channel(const Medium& medium, int c, double A) {
    const double sigma_a = medium.sigma_a[c];
    const double sigma_t_prime = double(medium.sigma_s_prime[c]) + sigma_a;
    const double z_r = 1 / sigma_t_prime;
    return {F(medium.sigma_s_prime[c] / sigma_t_prime), F(std::sqrt(3 * sigma_a * sigma_t_prime)),
            F(z_r), F(z_r * (1 + 4 * A / 3))};
}

/// Internal reflection parameter A = (1 + F_dr) / (1 - F_dr) of the dipole's boundary condition.
double mismatch_A(double eta);

/// The same from the polynomials that the papers print for F_dr: fits, within 0.0017 of it for eta
/// from 0.7 to 2, and 0.016 off at 3.
///
///     eta >= 1: -1.440 / eta^2 + 0.710 / eta + 0.668 + 0.0636 eta
///     eta <  1: -0.4399 + 0.7099 / eta - 0.3319 / eta^2 + 0.0636 / eta^3
///
/// Domain   0.5 <= eta <= 3; past 3.5 the fit exceeds 1, which no reflectance does.
/// Source   Egan, Hilgeman 1973; [JMLH01] section 2.1 prints the first, [JB02] both.
double classic_mismatch_A(double eta);

/// Diffuse reflectance R_d of a semi-infinite medium at squared surface distance r2.
///
///     R_d     = alpha' / (4 pi) (pole(z_r) + pole(z_v))
///     pole(z) = z (1 + sigma_tr d) e^(-sigma_tr d) / d^3,   d^2 = r2 + z^2
///
/// Units    r2 [mm^2] -> R_d [1/mm^2]; integrates over the plane to total_reflectance().
/// Domain   r2 >= 0. Finite at r2 = 0 because z_r > 0.
/// Source   [JMLH01] eq. 4. Both poles carry z / d^3, so that their dimensions agree; printed
///          versions lose the z_r, or use d_r inside the pole of z_v.
template <class F>
F diffuse_reflectance(const DipoleChannel<F>& m, F r2) {
    const auto pole = [&](F z) {
        const F d2 = r2 + z * z;
        const F d = std::sqrt(d2);
        const F x = m.sigma_tr * d;
        return z * (1 + x) * std::exp(-x) / (d2 * d);
    };
    return m.alpha_prime * F(0.25 * std::numbers::inv_pi) * (pole(m.z_r) + pole(m.z_v));
}

/// Integral of diffuse_reflectance over the plane.
///
///     alpha' / 2 (e^(-sigma_tr z_r) + e^(-sigma_tr z_v))
///
/// Source   [JMLH01] section 2.3 prints the same as alpha'/2 (1 + e^(-4/3 A s)) e^(-s),
///          s = sqrt(3 (1 - alpha')).
template <class F>
F total_reflectance(const DipoleChannel<F>& m) {
    return m.alpha_prime / 2 * (std::exp(-m.sigma_tr * m.z_r) + std::exp(-m.sigma_tr * m.z_v));
}

}  // namespace tallow
