// SPDX-License-Identifier: Apache-2.0
// Integrals of a profile against Gaussians, by the trapezoidal rule in tau = ln(z / sigma) + z /
// sigma: steps are relative where z is small against sigma, so that a sharp centre is met however
// sharp, and of one length where it is large. Integrands are analytic in tau, and the rule's error
// falls exponentially with its step. R * g is computed on a grid and joined by a spline in ln(R *
// g).
#include "common/exitance/smoothed_profile.h"

// clang-format off
#include <math.h>  // before Boost's, which in 1.74 call a global isnan
#include <boost/math/interpolators/cardinal_quintic_b_spline.hpp>
// clang-format on
#include <algorithm>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <numbers>

namespace tallow {
namespace {

constexpr double kPiD = std::numbers::pi;
constexpr double kStep = 0.12;      // of tau; chosen for the error that SmoothedProfile states
constexpr double kInnerZ = 1e-6;    // mean free paths; less than 1e-7 of any profile lies inside
constexpr double kReach = 8.5;      // standard deviations; e^(-kReach^2 / 2) is 2e-16
constexpr double kNodesEnd = 25;    // sigma
constexpr double kWindowFrom = 16;  // sigma; from here on R varies slowly against g, or is nothing
constexpr double kGridStep = 0.06;  // of t = ln(1 + (r / sigma)^2) / 2
constexpr double kEnd = 1e-15;      // of the total per sigma^2 (or mean free path^2)

// e^-x I_0(x), e^-x I_1(x); from kAsymptotic on by their asymptotic series, good to 1e-9.
constexpr double kAsymptotic = 40;

double scaled_bessel_i0(double x) {
    if (x < kAsymptotic) return std::exp(-x) * boost::math::cyl_bessel_i(0, x);
    const double y = 1 / (8 * x);
    return (1 + y * (1 + y * (4.5 + y * (37.5 + y * 459.375)))) / std::sqrt(2 * kPiD * x);
}

double scaled_bessel_i1(double x) {
    if (x < kAsymptotic) return std::exp(-x) * boost::math::cyl_bessel_i(1, x);
    const double y = 1 / (8 * x);
    return (1 - y * (3 + y * (7.5 + y * (52.5 + y * 590.625)))) / std::sqrt(2 * kPiD * x);
}

// Nodes z_k and weights such that the sum of weight f(z_k) is the integral of R(z) f(z) z dz.
struct Node {
    double z, weight;
};

std::vector<Node> quadrature(const Profile& profile, double mean_free_path, double sigma) {
    double zeta = kInnerZ * mean_free_path / sigma;  // z / sigma
    std::vector<Node> nodes;
    for (double tau = std::log(zeta) + zeta; zeta < kNodesEnd; tau += kStep) {
        for (int i = 0; i < 6; ++i) {  // Newton's method; the last node is near
            const double step = (tau - zeta - std::log(zeta)) / (1 + 1 / zeta);
            zeta = std::max(zeta + step, 0.1 * zeta);
        }
        const double z = sigma * zeta, dz = kStep * sigma * zeta / (1 + zeta);
        nodes.push_back({z, dz * z * profile(z * z)});
    }
    return nodes;
}

// Integral of g over directions, from a point at r to those of a circle of radius z.
double ring_weight(double r, double z, Smoothing smoothing) {
    const double sigma2 = smoothing.sigma * smoothing.sigma, x = r * z / sigma2;
    const double half_d2 = 0.5 * (r - z) * (r - z) / sigma2;
    const double i0 = scaled_bessel_i0(x);
    double sharpened = i0;
    if (smoothing.t > 0)
        sharpened += smoothing.t * ((1 - half_d2) * i0 - x * (i0 - scaled_bessel_i1(x)));
    return std::exp(-half_d2) * sharpened / sigma2;
}

double smoothed_near(const std::vector<Node>& nodes, double r, Smoothing smoothing) {
    double sum = 0;
    for (const Node& node : nodes)
        if (std::abs(r - node.z) < kReach * smoothing.sigma)
            sum += node.weight * ring_weight(r, node.z, smoothing);
    return sum;
}

double smoothed_far(const Profile& profile, double r, Smoothing smoothing) {
    constexpr double kWindowStep = 0.25;  // sigma
    const double sigma = smoothing.sigma;
    double sum = 0;
    for (double d = -kReach; d <= kReach; d += kWindowStep) {
        const double z = r + d * sigma;
        sum += kWindowStep * sigma * z * profile(z * z) * ring_weight(r, z, smoothing);
    }
    return sum;
}

// beta is the integral of R(r) phi(r / sigma): the transform of (1 - g^)^2 / k^2 over
// its own integral. With (1 - e^(-a k^2)) / k^2 written as an integral over a, it is one of
// Gaussians, and over k then in closed form:
//
//     phi(rho) = (2 J(sqrt(1/2)) - J(1)) / (sqrt(2) - 1),   J(b) = integral_0^b I0e(rho^2 / 8 t^2)
//     dt
double edge_weight(double rho) {
    const auto J = [rho](double b) {
        constexpr int n = 48;
        double sum = 0;
        for (int i = 0; i < n; ++i) {
            const double t = b * (i + 0.5) / n;
            sum += scaled_bessel_i0(rho * rho / (8 * t * t));
        }
        return sum * b / n;
    };
    return (2 * J(std::sqrt(0.5)) - J(1)) / (std::sqrt(2.0) - 1);
}

}  // namespace

struct SmoothedProfile::Curve {
    boost::math::interpolators::cardinal_quintic_b_spline<double> log_value;
};

SmoothedProfile::SmoothedProfile(const Profile& profile, double mean_free_path, Smoothing smoothing)
    : sigma_(smoothing.sigma), total_(profile.total_reflectance()), end_(0) {
    const double sigma = smoothing.sigma;
    const std::vector<Node> nodes = quadrature(profile, mean_free_path, sigma);
    const double scale = std::max(mean_free_path, sigma);
    const double end = kEnd * total_ / (scale * scale);
    std::vector<double> values;
    for (double t = 0;; t += kGridStep) {
        const double r = sigma * std::sqrt(std::expm1(2 * t));
        const double value = r < kWindowFrom * sigma ? smoothed_near(nodes, r, smoothing)
                                                     : smoothed_far(profile, r, smoothing);
        if (!(value > end)) break;
        values.push_back(std::log(value));
        end_ = r;
    }
    constexpr std::size_t kFewest = 8;  // that the spline takes; a profile of 0 has none
    if (values.size() < kFewest)
        end_ = 0;
    else
        curve_ = std::make_unique<Curve>(Curve{{values, 0.0, kGridStep}});
}

SmoothedProfile::~SmoothedProfile() = default;

double SmoothedProfile::operator()(double r2) const {
    if (r2 >= end_ * end_) return 0;
    return std::exp(curve_->log_value(0.5 * std::log1p(r2 / (sigma_ * sigma_))));
}

NearbyParts nearby_parts(const Profile& profile, double mean_free_path, double sigma) {
    NearbyParts parts{0, 0, 0};
    for (const Node& node : quadrature(profile, mean_free_path, sigma)) {
        const double rho = node.z / sigma, q = rho * rho / 4;
        parts.beta += 2 * kPiD * node.weight * edge_weight(rho);
        parts.kappa += 2 * kPiD * node.weight * (1 - 2 * q + q * q / 2) * std::exp(-q);
        parts.centre += node.weight * std::exp(-2 * q) / (sigma * sigma);
    }
    return parts;
}

}  // namespace tallow
