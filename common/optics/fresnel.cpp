// SPDX-License-Identifier: Apache-2.0
// Exact Fresnel equations for a smooth dielectric and their hemispherical averages.
#include "common/optics/fresnel.h"

#include <cmath>

namespace tallow {
namespace {

template <class F>
F reflectance(F eta, F cos_i) {
    const F sin2_t = (1 - cos_i * cos_i) / (eta * eta);
    if (sin2_t >= 1) return 1;
    const F cos_t = std::sqrt(1 - sin2_t);
    const F parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    const F perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    return (parallel * parallel + perpendicular * perpendicular) / 2;
}

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
            sum += kWeight[i] * reflectance(eta, mu) * std::pow(mu, k) * 2 * t;
        }
    return sum * (b - a) / (2 * kPanels);
}

}  // namespace

double fresnel_reflectance(double eta, double cos_i) { return reflectance(eta, cos_i); }
float fresnel_reflectance(float eta, float cos_i) { return reflectance(eta, cos_i); }

float refracted_cosine(float eta, float cos_i) {
    return std::sqrt(std::fmax(0.0f, 1 - (1 - cos_i * cos_i) / (eta * eta)));
}

std::optional<Vec3> refract(Vec3 w, Vec3 n, float eta) {
    const float cos_i = glm::dot(w, n);
    const float cos2_t = 1 - (1 - cos_i * cos_i) / (eta * eta);
    if (cos2_t <= 0) return std::nullopt;
    return glm::normalize((cos_i / eta - std::sqrt(cos2_t)) * n - w / eta);
}

double fresnel_moment(double eta, int k) {
    const double mu_critical = eta < 1 ? std::sqrt(1 - eta * eta) : 0;
    const double total_reflection = std::pow(mu_critical, k + 1) / (k + 1);
    return total_reflection + integrate(eta, k, mu_critical, 1);
}

double diffuse_fresnel_reflectance(double eta) { return 2 * fresnel_moment(1 / eta, 1); }
double diffuse_fresnel_transmittance(double eta) { return 1 - 2 * fresnel_moment(eta, 1); }

}  // namespace tallow
