// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/leaving_radiance.h"

#include <numbers>

namespace tallow {
namespace {

// Mean free paths along a way.
constexpr std::array kWayNodes = {0.1, 0.4, 1.1, 2.5};

// Of the cone: between its axis and the steepest refraction, 1 / eta.
constexpr float kSine = 0.6f, kCosine = 0.8f;

constexpr std::size_t kAround = LeavingRays::kDirections - 1;  // on the cone; the last is its axis

}  // namespace

LeavingRays::LeavingRays(Vec3 position, Vec3 normal, double mean_free_path)
    : position_(position), frame_(make_frame(normal)), mean_free_path_(mean_free_path) {}

Vec3 LeavingRays::tangent(std::size_t d) const {
    const float angle = 2 * std::numbers::pi_v<float> * float(d) / float(kAround);
    return std::cos(angle) * frame_.s + std::sin(angle) * frame_.t;
}

Vec3 LeavingRays::direction(std::size_t d) const {
    return d == kAround ? frame_.n : kSine * tangent(d) + kCosine * frame_.n;
}

Vec3 LeavingRays::place(std::size_t d, std::size_t node) const {
    return position_ - float(kWayNodes[node] * mean_free_path_) * direction(d);
}

LeavingRadiance LeavingRays::fit(
    const std::array<std::array<double, kNodes>, kDirections>& fluence) const {
    const auto weights = decay_weights(kWayNodes, 1);
    std::array<float, kDirections> F{};
    for (std::size_t d = 0; d < kDirections; ++d) {
        double sum = 0;
        for (std::size_t k = 0; k < kNodes; ++k) sum += weights[k] * fluence[d][k];
        F[d] = float(sum);
    }
    float mean = 0;
    for (std::size_t d = 0; d < kAround; ++d) mean += F[d] / float(kAround);
    Vec3 slope = (F[kAround] - mean) / (1 - kCosine) * frame_.n;
    for (std::size_t d = 0; d < kAround; ++d)
        slope += 2 / float(kAround) * (F[d] - mean) / kSine * tangent(d);
    return {F[kAround] - glm::dot(slope, frame_.n), slope};
}

}  // namespace tallow
