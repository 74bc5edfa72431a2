// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tallow {

/// Part of the light that enters a half-space at right angles and leaves it after exactly one
/// collision, by Henyey-Greenstein scattering of mean cosine g and Fresnel transmittance T at the
/// exit. For g = 0:
///
///     alpha integral over t of e^-t, over mu of T(mu) e^(-t / mu) / 2
///         = alpha / 2 * integral of T(mu) mu / (1 + mu) over [0, 1]
///
/// (1 - ln 2) / 2 for matched indices. Otherwise the integrand is multiplied with 4 pi p(-mu).
/// What the surface reflects inwards belongs to higher orders.
double single_scattering_reflectance(double alpha, double eta, double g = 0);

/// The same as a function of the distance r between entry and exit, in mean free paths.
///
///     R_1 = alpha / (4 pi r) * integral of T(cos theta) cos theta e^(-r cot(theta / 2)) d theta
///
/// from 0 to the critical angle; theta is the angle at the exit, so that the collision lies
/// r cot(theta) deep and the path is r cot(theta) + r / sin(theta) long.
///
/// Units    r in mean free paths > 0, the result per mean free path^2. Falls with r; as 1/r at 0.
double single_scattering_profile(double alpha, double eta, double r);

}  // namespace tallow
