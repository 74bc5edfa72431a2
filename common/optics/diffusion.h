// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "common/optics/medium.h"

namespace tallow {

/// One channel of a medium in units of its reduced mean free path 1 / sigma_t'.
struct ReducedChannel {
    double alpha_prime;
    double absorption;  ///< sigma_a / sigma_t' = 1 - alpha', without the cancellation
    double sigma_t_prime;
    double eta;
};
ReducedChannel reduced_channel(const Medium& medium, int channel);

/// Constants of diffusion with Grosjean's coefficient and the exact moments of the internal Fresnel
/// reflectance R at the boundary; lengths in reduced mean free paths.
///
///     C1 = integral of R mu, C2 = integral of R mu^2 over [0, 1]
///     A = (1 + 3 C2) / (1 - 2 C1),   C_phi = (1 - 2 C1) / 4,   C_E = (1 - 3 C2) / 2
///     D = (1 + absorption) / 3,      s = sqrt(absorption / D),  z_b = 2 A D
///
/// Source   [d'Eon12]; D is Grosjean's (2 sigma_a + sigma_s') / (3 sigma_t'^2).
struct DiffusionConstants {
    double A, C_phi, C_E, D, s, z_b;
};
DiffusionConstants diffusion_constants(double absorption, double eta);

/// Source at depth z and its mirror image at height z_v, seen from the surface at r2.
///
///     flux    = z (1 + s d) e^(-s d) / d^3 + the same of z_v
///     fluence = e^(-s d) / d - e^(-s d_v) / d_v,     d^2 = r2 + z^2
///
/// The difference is taken without cancellation far away, where d and d_v meet.
struct ImagePair {
    double flux, fluence, d;
};
inline ImagePair image_pair(double r2, double z, double z_v, double s) {
    const double d = std::sqrt(r2 + z * z), d_v = std::sqrt(r2 + z_v * z_v);
    const double gap = (z_v - z) * (z_v + z) / (d + d_v);  // d_v - d
    const double near = std::exp(-s * d) / d;
    const double lost = -std::expm1(-s * gap);
    const double far = near * d / d_v * (1 - lost);
    return {z * (1 + s * d) * near / (d * d) + z_v * (1 + s * d_v) * far / (d_v * d_v),
            near * (gap / d_v + lost * d / d_v), d};
}

/// The pair of a source at depth z whose image makes the fluence vanish at height z_b.
inline ImagePair image_pair(double r2, double z, const DiffusionConstants& k) {
    return image_pair(r2, z, z + 2 * k.z_b, k.s);
}

/// Fluence at the surface of a half-space of a source at depth z, times 4 pi D, for the boundary
/// condition phi = 2 A D dphi/dn itself, which an image only approximates:
///
///     2 * integral over l of h e^(-h l) (e^(-s d) / d - e^(-s d_l) / d_l),   h = 1 / (2 A D),
///     d_l^2 = r2 + (z + l)^2
///
/// Source   the line of images of a radiation boundary condition, e.g. [CJ59] section 14.10.
double half_space_fluence(double r2, double z, const DiffusionConstants& k);

/// C_E flux + C_phi / D fluence: what of a pair's light leaves, times 4 pi. Source: [d'Eon12].
inline double exitance(const ImagePair& pair, const DiffusionConstants& k) {
    return k.C_E * pair.flux + k.C_phi / k.D * pair.fluence;
}

}  // namespace tallow
