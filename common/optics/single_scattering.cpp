// SPDX-License-Identifier: Apache-2.0
#include "common/optics/single_scattering.h"

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>

#include "common/optics/fresnel.h"
#include "common/optics/phase.h"

namespace tallow {
namespace {

// Transmittance has a square-root singularity at the critical angle; the substitution
// x = critical (1 - v^2) removes it.
template <class F>
double integrate_to_critical(double critical, F&& f) {
    const auto substituted = [&](double v) { return 2 * v * f(critical * (1 - v * v)); };
    return critical * boost::math::quadrature::gauss<double, 50>::integrate(substituted, 0.0, 1.0);
}

double critical_angle(double eta) { return eta > 1 ? std::asin(1 / eta) : 0.5 * std::numbers::pi; }

double transmittance(double eta, double mu) { return 1 - fresnel_reflectance(1 / eta, mu); }

}  // namespace

double single_scattering_reflectance(double alpha, double eta, double g) {
    const double integral = integrate_to_critical(critical_angle(eta), [&](double theta) {
        const double mu = std::cos(theta);
        const double phase =
            g == 0 ? 1.0 : 4 * std::numbers::pi * double(henyey_greenstein(float(g), float(-mu)));
        return phase * transmittance(eta, mu) * mu / (1 + mu) * std::sin(theta);
    });
    return alpha / 2 * integral;
}

double single_scattering_profile(double alpha, double eta, double r) {
    const double integral = integrate_to_critical(critical_angle(eta), [&](double theta) {
        const double mu = std::cos(theta);
        return transmittance(eta, mu) * mu * std::exp(-r / std::tan(theta / 2));
    });
    return alpha / (4 * std::numbers::pi * r) * integral;
}

}  // namespace tallow
