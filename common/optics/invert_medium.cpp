// SPDX-License-Identifier: Apache-2.0
// Diffuse colour -> reduced albedo. Total reflectance depends on alpha', eta and g only, not on the
// mean free path, and falls monotonically with absorption from largest_reflectance() to 0; near
// alpha' = 1 it falls as the square root of 1 - alpha', so the root is sought in that variable.
#include "common/optics/invert_medium.h"

#include <boost/math/tools/toms748_solve.hpp>
#include <cstdint>

namespace tallow {
namespace {

constexpr double kSlack = 1e-6;  // above the largest reflectance: rounding of the user's decimals

double reflectance_of(Model model, double absorbed, float eta, float g) {
    const ChannelCoefficients k = channel_coefficients(absorbed, 1);
    const Medium medium{Rgb(k.sigma_a), Rgb(k.sigma_s_prime), g, eta};
    return make_profile(model, medium, 0, Orders::all)->total_reflectance();
}

}  // namespace

double largest_reflectance(Model model, float eta, float g) {
    return reflectance_of(model, 0, eta, g);
}

std::optional<double> invert_reflectance(Model model, double reflectance, float eta, float g) {
    const double largest = largest_reflectance(model, eta, g);
    if (reflectance > largest + kSlack) return std::nullopt;
    if (reflectance >= largest) return 0;
    if (reflectance <= 0) return 1;

    // Nothing comes back from a pure absorber, which closes the bracket without asking the model.
    const auto excess = [&](double root) {
        return reflectance_of(model, root * root, eta, g) - reflectance;
    };
    // 26 bits of sqrt(1 - alpha'), whose slope is at most a few: 1e-7 in reflectance.
    const boost::math::tools::eps_tolerance<double> precise(26);
    std::uintmax_t iterations = 100;
    const auto [low, high] = boost::math::tools::toms748_solve(
        excess, 0.0, 1.0, largest - reflectance, -reflectance, precise, iterations);
    const double root = (low + high) / 2;
    return root * root;
}

ChannelCoefficients channel_coefficients(double absorbed, double mean_free_path) {
    return {float(absorbed / mean_free_path), float((1 - absorbed) / mean_free_path)};
}

}  // namespace tallow
