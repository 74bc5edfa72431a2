// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "common/diffusion/boundary_sum.h"
#include "common/diffusion/surface_clusters.h"

namespace tallow {

/// Weights of values at nodes z_0 < z_1 < ... in the integral over z >= 0 of f(z) e^(-z / m) / m,
/// f linear between nodes and on to z = 0, and constant behind the last.
template <std::size_t N>
std::array<double, N> decay_weights(const std::array<double, N>& z, double m) {
    std::array<double, N> weights{};
    const auto zeroth = [m](double a) { return std::exp(-a / m); };
    const auto first = [&](double a) { return (a + m) * zeroth(a); };
    for (std::size_t k = 0; k + 1 < N; ++k) {
        const double begin = k == 0 ? 0 : z[k], width = z[k + 1] - z[k];
        const double of_one = zeroth(begin) - zeroth(z[k + 1]);
        const double of_z = first(begin) - first(z[k + 1]);
        weights[k] += (z[k + 1] * of_one - of_z) / width;
        weights[k + 1] += (of_z - z[k] * of_one) / width;
    }
    weights[N - 1] += zeroth(z[N - 1]);
    return weights;
}

/// Light that leaves the body, by its direction w' inside, before it crosses the surface:
///
///     F(w') = even + slope . w'
///
/// the integral of the fluence along the way it came, weighted with e^(-way / mean free path).
struct LeavingRadiance {
    float even = 0;
    Vec3 slope{0};
};

/// The ways along which LeavingRadiance is found, at one cluster: four directions of a cone that
/// refraction can reach, four places on each.
class LeavingRays {
public:
    static constexpr std::size_t kDirections = 4, kNodes = 4;

    LeavingRays(Vec3 position, Vec3 normal, double mean_free_path);

    /// Place `node` of the way that leaves along `direction`, mm.
    Vec3 place(std::size_t direction, std::size_t node) const;

    /// From the fluence [direction][node]; 0 where the way has left the body.
    LeavingRadiance fit(const std::array<std::array<double, kNodes>, kDirections>& fluence) const;

private:
    Vec3 direction(std::size_t d) const;
    Vec3 tangent(std::size_t d) const;

    Vec3 position_;
    Frame frame_;
    double mean_free_path_;
};

}  // namespace tallow
