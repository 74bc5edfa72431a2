// SPDX-License-Identifier: Apache-2.0
// Points seen from outside -> pieces of the way of their eye rays inside, many rays at a time.
#include "render/eye_path.h"

#include <algorithm>
#include <cmath>

#include "common/optics/fresnel.h"

namespace tallow {
namespace {

constexpr float kLeastShare = 3e-3f;  // of what the first segment can bring
constexpr int kMostSegments = 12;     // chosen: in a wedge light is reflected totally a few times

Rgb transmittance(Rgb sigma, float length) {
    Rgb result;
    for (int c = 0; c < 3; ++c) result[c] = std::exp(-sigma[c] * length);
    return result;
}

/// A segment whose end is not known yet, and the ray that finds it.
struct Open {
    EyeSegment segment;
    ShadowRay ray;
    float first;  // weight of the point's first segment
};

class EyeRays {
public:
    explicit EyeRays(const ScatteringBody& body) : body_(body), sigma_t_(body.medium.sigma_t()) {}

    void enter(std::size_t index, const EyePoint& point) {
        const Hit& hit = point.hit;
        const auto w_inside = refract(point.w_o, hit.n, body_.medium.eta);
        if (!w_inside) return;
        const Vec3 start = body_.rays.offset_origin(hit.position, hit.n_g, *w_inside);
        open_.push_back({{index, hit.position, *w_inside, kInfinity, Rgb(1)},
                         {start, *w_inside, kInfinity},
                         0});
    }

    std::vector<EyeSegment> follow() {
        for (int k = 0; k < kMostSegments && !open_.empty(); ++k) close_all();
        std::stable_sort(
            closed_.begin(), closed_.end(),
            [](const EyeSegment& a, const EyeSegment& b) { return a.point < b.point; });
        return std::move(closed_);
    }

private:
    void close_all() {
        std::vector<ShadowRay> rays;
        for (const Open& open : open_) rays.push_back(open.ray);
        std::vector<std::optional<Hit>> ends(rays.size());
        body_.rays.intersect_object(rays, body_.object, ends);
        std::vector<Open> next;
        for (std::size_t i = 0; i < open_.size(); ++i) close(open_[i], ends[i], next);
        open_ = std::move(next);
    }

    void close(Open& open, const std::optional<Hit>& end, std::vector<Open>& next) {
        EyeSegment& segment = open.segment;
        if (end) segment.length = glm::length(end->position - segment.start);
        if (segment.length <= 0) return;
        closed_.push_back(segment);
        if (!end || body_.exact == nullptr) return;
        if (open.first == 0) open.first = weight_of(segment, sigma_t_);
        reflect(open, *end, next);
    }

    void reflect(const Open& open, const Hit& end, std::vector<Open>& next) const {
        const EyeSegment& before = open.segment;
        const auto reflection = reflect_inside(before.direction, end, body_.medium.eta);
        if (!reflection) return;
        const Rgb throughput =
            reflection->reflectance * before.throughput * transmittance(sigma_t_, before.length);
        if (mean(throughput) < kLeastShare * open.first) return;
        const Vec3 w = reflection->direction;
        next.push_back({{before.point, end.position, w, kInfinity, throughput},
                        {body_.rays.offset_origin(end.position, end.n_g, w), w, kInfinity},
                        open.first});
    }

    const ScatteringBody& body_;
    Rgb sigma_t_;
    std::vector<Open> open_;
    std::vector<EyeSegment> closed_;
};

}  // namespace

std::optional<InnerReflection> reflect_inside(Vec3 direction, const Hit& end, float eta) {
    const float cos_g = glm::dot(direction, end.n_g), cos_n = glm::dot(direction, end.n);
    if (cos_g <= 0) return std::nullopt;
    const Vec3 n = cos_n > 0 ? end.n : end.n_g;
    const float reflectance =
        fresnel_reflectance(1 / eta, std::min(1.0f, cos_n > 0 ? cos_n : cos_g));
    const Vec3 w = glm::normalize(-reflect(direction, n));
    if (glm::dot(w, end.n_g) < 0) return InnerReflection{w, reflectance};
    return InnerReflection{glm::normalize(-reflect(direction, end.n_g)), reflectance};
}

std::vector<EyeSegment> follow_eye_rays(const ScatteringBody& body,
                                        std::span<const EyePoint> points) {
    EyeRays rays(body);
    for (std::size_t i = 0; i < points.size(); ++i) rays.enter(i, points[i]);
    return rays.follow();
}

float weight_of(const EyeSegment& segment, Rgb sigma_t) {
    Rgb lost;
    for (int c = 0; c < 3; ++c) lost[c] = -std::expm1(-sigma_t[c] * segment.length);
    return mean(segment.throughput * lost);
}

}  // namespace tallow
