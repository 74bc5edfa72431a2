// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "common/base/rgb.h"

namespace tallow {

/// A depth drawn along a ray, in mm, and what light keeps on its way from there over the density
/// with which it was drawn: e^(-sigma s) / p(s), in mm.
struct Depth {
    float s;
    Rgb weight;
};

/// Draws depths along a ray of length s_max with density proportional to the mean over channels of
/// sigma e^(-sigma s) / (1 - e^(-sigma s_max)), so that channels of very different density are all
/// served.
///
/// Domain   sigma > 0 in each channel, s_max > 0, may be infinite.
class DepthSampler {
public:
    DepthSampler(Rgb sigma, float s_max)
        : sigma_(sigma), high_(std::min(s_max, 100 / min_channel(sigma))) {
        for (int c = 0; c < 3; ++c) per_reach_[c] = -1 / std::expm1(-sigma[c] * s_max);
    }

    /// Inverse of the cumulative distribution at u in [0, 1), by Newton's method inside a shrinking
    /// bracket. It starts from the inverse for the mean channel alone, which most media are close
    /// to, and ends when a step was so small that the error, which each step squares, is below
    /// 1e-6.
    Depth operator()(float u) const {
        constexpr float kLastStep = 1e-3f;
        float low = 0, high = high_;
        const float sigma = mean(sigma_);
        float s = std::min(high, -std::log1p(u * std::expm1(-sigma * high)) / sigma);
        for (int i = 0; i < 40; ++i) {
            const auto [cumulative, density] = distribution(s);
            const float error = cumulative - u;
            (error > 0 ? high : low) = s;
            float next = s - error / density;
            const bool inside = next > low && next < high;
            if (!inside) next = 0.5f * (low + high);
            const float step = std::abs(next - s);
            s = next;
            if (step <= (inside ? kLastStep : 1e-5f) * s) break;
        }
        Rgb transmitted;
        float density = 0;
        for (int c = 0; c < 3; ++c) {
            transmitted[c] = std::exp(-sigma_[c] * s);
            density += sigma_[c] * per_reach_[c] * transmitted[c] * (1.0f / 3);
        }
        return {s, transmitted / density};
    }

private:
    struct Distribution {
        float cumulative, density;
    };
    Distribution distribution(float s) const {
        Distribution at{0, 0};
        for (int c = 0; c < 3; ++c) {
            const float lost = -std::expm1(-sigma_[c] * s);
            at.cumulative += per_reach_[c] * lost * (1.0f / 3);
            at.density += sigma_[c] * per_reach_[c] * (1 - lost) * (1.0f / 3);
        }
        return at;
    }

    Rgb sigma_;
    Rgb per_reach_;  // 1 / (1 - e^(-sigma s_max))
    float high_;     // beyond lies nothing that counts
};

}  // namespace tallow
