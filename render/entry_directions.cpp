// SPDX-License-Identifier: Apache-2.0
// A lamp, a place and normals of the surface near it -> directions inside, with their density.
#include "render/entry_directions.h"

#include <algorithm>
#include <cmath>

#include "common/optics/fresnel.h"

namespace tallow {
namespace {

// Part of the directions that are drawn around those that planes give. Chosen.
constexpr float kWide = 0.5f;

// Angle by which normals of facets turn light from where a plane would send it. Chosen.
constexpr float kTurn = 0.15f;

float wide_density(float m, float cosine) {
    const float d = 1 - cosine + m;
    return m * (2 + m) / (2 * kTwoPi * d * d);
}

float wide_one_minus_cos(float m, float u) {
    const float v = 2 * u / (2 + m);
    return m * v / (1 - v);
}

}  // namespace

std::optional<Vec3> refract_outwards(Vec3 direction, Vec3 n, float eta) {
    return refract(-direction, -n, 1 / eta);
}

EntryDirections::EntryDirections(const Light& light, const std::optional<LightBall>& ball, Vec3 x,
                                 float eta)
    : light_(light), finite_(ball.has_value()), x_(x), eta_(eta) {
    if (!ball) return;
    const Vec3 d = ball->center - x;
    const float distance = glm::length(d);
    to_lamp_ = distance > 0 ? d / distance : Vec3(0, 1, 0);
    rim_ = std::min(1.0f, ball->radius / std::max(distance, 1e-30f));
}

void EntryDirections::add(Vec3 n, float likely) {
    if (!(likely > 0) || count_ == kMost) return;
    Plane& plane = planes_[count_];
    plane = {n, likely, n, 0};
    const float cos_c = std::sqrt(std::max(0.0f, 1 - 1 / (eta_ * eta_)));
    if (finite_) {
        constexpr float kLeastCos = 0.05f;
        const float cosine = glm::dot(to_lamp_, n);
        const Vec3 w =
            cosine >= kLeastCos ? to_lamp_ : glm::normalize(to_lamp_ + (kLeastCos - cosine) * n);
        plane.axis = -refract(w, n, eta_).value_or(-n);
        const float sine = std::min(1.0f, (rim_ + kTurn) / eta_);
        plane.m = sine * sine / (1 + std::sqrt(1 - sine * sine));
    } else {
        plane.m = 1 - cos_c + kTurn * kTurn;
    }
    likely_ += likely;
    ++count_;
}

std::optional<Vec3> EntryDirections::draw(Vec2 u) const {
    float rest = u.x * likely_;
    std::size_t k = 0;
    for (; k + 1 < count_ && rest >= planes_[k].likely; ++k) rest -= planes_[k].likely;
    const Plane& plane = planes_[k];
    u.x = std::clamp(rest / plane.likely, 0.0f, 0x1.fffffep-1f);
    if (u.x < kWide) {
        u.x /= kWide;
        const float below = wide_one_minus_cos(plane.m, u.x), phi = kTwoPi * u.y;
        const float sine = std::sqrt(std::max(0.0f, below * (2 - below)));
        return glm::normalize(
            make_frame(plane.axis)
                .to_world({sine * std::cos(phi), sine * std::sin(phi), 1 - below}));
    }
    u.x = std::min((u.x - kWide) / (1 - kWide), 0x1.fffffep-1f);
    const auto lamp = sample_light(light_, x_, plane.n, u);
    if (!lamp || glm::dot(lamp->w_i, plane.n) <= 0) return std::nullopt;
    const auto inside = refract(lamp->w_i, plane.n, eta_);
    if (!inside) return std::nullopt;
    return -*inside;
}

float EntryDirections::density(Vec3 direction) const {
    float sum = 0;
    for (std::size_t k = 0; k < count_; ++k) {
        const Plane& plane = planes_[k];
        float here = kWide * wide_density(plane.m, glm::dot(direction, plane.axis));
        const float cos_d = glm::dot(direction, plane.n);
        const auto w = cos_d > 0 ? refract_outwards(direction, plane.n, eta_) : std::nullopt;
        const float cos_w = w ? glm::dot(*w, plane.n) : 0;
        if (cos_w > 0)
            here +=
                (1 - kWide) * light_density(light_, x_, plane.n, *w) * eta_ * eta_ * cos_d / cos_w;
        sum += plane.likely * here;
    }
    return sum / likely_;
}

}  // namespace tallow
