// SPDX-License-Identifier: Apache-2.0
// Single scattering by marching refracted eye rays, many at a time: depths are drawn along the way
// of a ray inside, and light is collected there.
#include "render/single_scatter.h"

#include <algorithm>
#include <cmath>

#include "common/base/rng.h"
#include "common/optics/fresnel.h"
#include "render/depth_sampler.h"
#include "render/eye_path.h"
#include "render/light_collector.h"

namespace tallow {
namespace {

/// Where step `index` of the `together` steps that are stratified together lies, in [0, 1). Steps
/// come in pairs, one stratum a pair, one the mirror image of the other in its middle: what changes
/// linearly over a stratum has no error.
float depth_sample(std::uint64_t seed, std::uint32_t index, int together) {
    const float u = sobol_third(index / 2, mix_bits(seed));
    if (index % 2 == 0) return u;
    const float strata = float(std::max(1, together / 2));
    const float below = std::floor(u * strata);
    return std::min((2 * below + 1) / strata - u, 0x1.fffffep-1f);
}

/// Lays places along the eye rays inside a body and collects the light there.
class March {
public:
    March(const ScatteringBody& body, std::span<const EyePoint> points, MarchSteps steps,
          std::span<Rgb> result)
        : points_(points),
          steps_(steps),
          sigma_t_(body.medium.sigma_t()),
          sigma_s_(body.medium.sigma_s()),
          collector_(body, points, result) {
        places_.reserve(collector_.batch());
    }

    /// All segments of one point's ray. A step falls on one of them with a chance that is
    /// proportional to its weight.
    void along(std::span<const EyeSegment> way) {
        float total = 0;
        weights_.clear();
        depths_.clear();
        for (const EyeSegment& segment : way) {
            weights_.push_back(weight_of(segment, sigma_t_));
            depths_.emplace_back(sigma_t_, segment.length);
            total += weights_.back();
        }
        const EyePoint& eye = points_[way.front().point];
        for (std::uint32_t k = 0; k < std::uint32_t(steps_.of_point); ++k) {
            const std::uint32_t index = eye.first_step + k;
            place(way, depth_sample(eye.seed, index, steps_.together), total, index);
        }
    }

    void finish() {
        collector_.add(places_);
        places_.clear();
    }

private:
    void place(std::span<const EyeSegment> way, float u, float total, std::uint32_t index) {
        std::size_t k = 0;
        float rest = u * total;
        for (; k + 1 < way.size() && rest >= weights_[k]; ++k) rest -= weights_[k];
        const EyeSegment& segment = way[k];
        if (!(weights_[k] > 0)) return;  // underflow
        const bool alone = way.size() == 1;
        const float within = alone ? u : std::clamp(rest / weights_[k], 0.0f, 0x1.fffffep-1f);
        const float share = alone ? 1.0f : weights_[k] / total;
        // Depths count from the surface itself: the offset only keeps the ray off it.
        const Depth depth = depths_[k](within);
        places_.push_back({segment.point, index, segment.start + depth.s * segment.direction,
                           segment.direction,
                           sigma_s_ * segment.throughput * depth.weight / share});
        if (places_.size() == collector_.batch()) finish();
    }

    std::span<const EyePoint> points_;
    MarchSteps steps_;
    Rgb sigma_t_, sigma_s_;
    LightCollector collector_;
    std::vector<Place> places_;
    std::vector<float> weights_;        // [segment of the point]
    std::vector<DepthSampler> depths_;  // likewise
};

}  // namespace

void single_scatter(const ScatteringBody& body, std::span<const EyePoint> points, MarchSteps steps,
                    std::span<Rgb> result) {
    std::fill(result.begin(), result.end(), Rgb(0));
    if (max_channel(body.medium.sigma_s_prime) == 0) return;
    const std::vector<EyeSegment> segments = follow_eye_rays(body, points);
    March march(body, points, steps, result);
    for (std::size_t first = 0, last = 0; first < segments.size(); first = last) {
        while (last < segments.size() && segments[last].point == segments[first].point) ++last;
        march.along({segments.data() + first, last - first});
    }
    march.finish();
    const float eta = body.medium.eta;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (max_channel(result[i]) == 0) continue;
        const float transmitted =
            fresnel_transmittance(eta, glm::dot(points[i].w_o, points[i].hit.n));
        result[i] *= transmitted / (eta * eta * float(steps.of_point)) *
                     surface_tint(body.scene, body.albedo, points[i].hit);
    }
}

Rgb single_scatter(const ScatteringBody& body, const EyePoint& point, MarchSteps steps) {
    Rgb result;
    single_scatter(body, {&point, 1}, steps, {&result, 1});
    return result;
}

}  // namespace tallow
