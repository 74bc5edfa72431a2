// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "common/base/rng.h"
#include "common/scene/light.h"

// Irradiance by a light on a small surface at x with normal n, nothing in the way.
namespace tallow::test {

/// Mean and variance of the samples of an estimate.
struct Estimate {
    DVec3 mean{0.0};
    DVec3 variance{0.0};    // of one sample
    DVec3 mean_error{0.0};  // standard error of the mean
};

/// f(u) -> Rgb over `count` points.
template <class F>
Estimate estimate(int count, F&& f) {
    DVec3 sum(0.0), sum2(0.0);
    for (int k = 0; k < count; ++k) {
        const Rgb value = f(k);
        const DVec3 v(value.r, value.g, value.b);
        sum += v;
        sum2 += v * v;
    }
    Estimate result;
    result.mean = sum / double(count);
    result.variance = glm::max(DVec3(0.0), sum2 / double(count) - result.mean * result.mean);
    result.mean_error = glm::sqrt(result.variance / double(count));
    return result;
}

inline Vec2 random_point(std::uint64_t seed, int k) {
    return {to_unit_float(random_bits(seed, 0, std::uint64_t(k))),
            to_unit_float(random_bits(seed, 1, std::uint64_t(k)))};
}

inline Rgb irradiance_sample(const Light& light, Vec3 x, Vec3 n, Vec2 u) {
    const auto sample = sample_light(light, x, n, u);
    return sample ? std::max(0.0f, glm::dot(sample->w_i, n)) * sample->radiance : Rgb(0);
}

/// By low-discrepancy points: the mean alone is of use.
inline DVec3 irradiance(const Light& light, Vec3 x, Vec3 n, int count = 1 << 14) {
    return estimate(count,
                    [&](int k) {
                        return irradiance_sample(light, x, n, sobol_2d(std::uint32_t(k), 77));
                    })
        .mean;
}

/// By independent points.
inline Estimate random_irradiance(const Light& light, Vec3 x, Vec3 n, int count) {
    return estimate(count,
                    [&](int k) { return irradiance_sample(light, x, n, random_point(5, k)); });
}

/// By looking around with density cos / pi.
inline Estimate seen_irradiance(const Light& light, Vec3 x, Vec3 n, int count) {
    const Frame frame = make_frame(n);
    return estimate(count, [&](int k) {
        const Vec2 u = random_point(6, k);
        const float sine = std::sqrt(u.x), phi = kTwoPi * u.y;
        const Vec3 w = glm::normalize(
            frame.to_world({sine * std::cos(phi), sine * std::sin(phi), std::sqrt(1 - u.x)}));
        const auto seen = see_light(light, {x, w});
        return seen ? kPi * seen->radiance : Rgb(0);
    });
}

/// By light points drawn without knowing the receiver.
inline Estimate point_irradiance(const Light& light, Vec3 x, Vec3 n, int count) {
    return estimate(count, [&](int k) {
        const LightPoint y = sample_light_point(light, random_point(7, k));
        const Vec3 d = y.at_infinity ? y.position : y.position - x;
        const float distance = y.at_infinity ? kInfinity : glm::length(d);
        const Vec3 w = glm::normalize(d);
        const Rgb I = intensity_towards(light, y, -w, distance);
        const float cosine = std::max(0.0f, glm::dot(w, n));
        return y.at_infinity ? cosine * I : cosine / (distance * distance) * I;
    });
}

}  // namespace tallow::test
