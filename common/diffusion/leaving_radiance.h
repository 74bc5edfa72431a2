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
///     X(w') = even + slope . w'
///
/// such that outside pi L = F_t / (2 * integral of F_t mu) X, W/mm^2.
struct LeavingRadiance {
    float even = 0;
    Vec3 slope{0};

    float at(Vec3 w) const { return even + glm::dot(slope, w); }
    void add(float scale, const LeavingRadiance& b) {
        even += scale * b.even;
        slope += scale * b.slope;
    }
};

/// Cosines inside of light that leaves evenly, L outside being F_t: their mean.
float mean_cosine_of_leaving(float eta);

/// The ways along which LeavingRadiance is found, at one place: four directions of a cone that
/// refraction can reach, four places on each.
class LeavingRays {
public:
    static constexpr std::size_t kDirections = 4, kNodes = 4;

    explicit LeavingRays(Vec3 normal) : frame_(make_frame(normal)) {}

    /// Of light that leaves, unit.
    Vec3 direction(std::size_t d) const;

    /// From the radiance of each direction.
    LeavingRadiance fit(const std::array<float, kDirections>& F) const;

private:
    Vec3 tangent(std::size_t d) const;

    Frame frame_;
};

}  // namespace tallow
