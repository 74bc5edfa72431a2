// SPDX-License-Identifier: Apache-2.0
// Exact Fresnel equations for a smooth dielectric and their hemispherical averages.
#include "common/optics/fresnel.h"

#include <cmath>

namespace tallow {
namespace {

// Five Gauss-Legendre nodes on [-1, 1].
constexpr double kNode[5] = {-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831,
                             0.9061798459386640};
constexpr double kWeight[5] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                               0.4786286704993665, 0.2369268850561891};

// Integral of F_r mu^k over [a, b], whose square-root singularity, if any, sits at a: the
// substitution mu = a + (b - a) t^2 removes it.
double integrate(double eta, int k, double a, double b) {
    constexpr int kPanels = 64;  // doubled: the result changes by less than 1e-12
    double sum = 0;
    for (int panel = 0; panel < kPanels; ++panel)
        for (int i = 0; i < 5; ++i) {
            const double t = (panel + 0.5 * (1 + kNode[i])) / kPanels;
            const double mu = a + (b - a) * t * t;
            sum += kWeight[i] * fresnel_reflectance(eta, mu) * std::pow(mu, k) * 2 * t;
        }
    return sum * (b - a) / (2 * kPanels);
}

}  // namespace

double fresnel_moment(double eta, int k) {
    const double mu_critical = eta < 1 ? std::sqrt(1 - eta * eta) : 0;
    const double total_reflection = std::pow(mu_critical, k + 1) / (k + 1);
    return total_reflection + integrate(eta, k, mu_critical, 1);
}

double diffuse_fresnel_reflectance(double eta) { return 2 * fresnel_moment(1 / eta, 1); }
double diffuse_fresnel_transmittance(double eta) { return 1 - 2 * fresnel_moment(eta, 1); }

}  // namespace tallow
