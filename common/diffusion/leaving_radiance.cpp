// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/leaving_radiance.h"

#include <cmath>
#include <numbers>

#include "common/optics/fresnel.h"

namespace tallow {
namespace {

// Of the cone: between its axis and the steepest refraction, 1 / eta.
constexpr float kSine = 0.6f, kCosine = 0.8f;

constexpr std::size_t kAround = LeavingRays::kDirections - 1;  // on the cone; the last is its axis

}  // namespace

float mean_cosine_of_leaving(float eta) {
    constexpr int kSteps = 500;  // of the midpoint rule
    float sum = 0, weights = 0;
    for (int i = 0; i < kSteps; ++i) {
        const float mu = (float(i) + 0.5f) / kSteps, weight = fresnel_transmittance(eta, mu) * mu;
        sum += weight * std::sqrt(1 - (1 - mu * mu) / (eta * eta)), weights += weight;
    }
    return sum / weights;
}

Vec3 LeavingRays::tangent(std::size_t d) const {
    const float angle = 2 * std::numbers::pi_v<float> * float(d) / float(kAround);
    return std::cos(angle) * frame_.s + std::sin(angle) * frame_.t;
}

Vec3 LeavingRays::direction(std::size_t d) const {
    return d == kAround ? frame_.n : kSine * tangent(d) + kCosine * frame_.n;
}

LeavingRadiance LeavingRays::fit(const std::array<float, kDirections>& F) const {
    float mean = 0;
    for (std::size_t d = 0; d < kAround; ++d) mean += F[d] / float(kAround);
    Vec3 slope = (F[kAround] - mean) / (1 - kCosine) * frame_.n;
    for (std::size_t d = 0; d < kAround; ++d)
        slope += 2 / float(kAround) * (F[d] - mean) / kSine * tangent(d);
    return {F[kAround] - glm::dot(slope, frame_.n), slope};
}

}  // namespace tallow
