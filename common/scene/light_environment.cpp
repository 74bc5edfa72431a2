// SPDX-License-Identifier: Apache-2.0
// Light from all directions. A constant one is drawn by cosine where there is a receiver's normal,
// from all directions where there is none; a picture by its table of what is brighter than its
// mean, mixed with that. Each direction is looked up by bilinear interpolation, and the table draws
// that same interpolant: see LightImage.
//
// Why the mixture: relative variance of the irradiance from one independent sample, mean over the
// 26 normals to the corners, edges and sides of a cube, by quadrature on 256 x 128 pixels. The sky
// is 0.3 at the zenith, 1 at the horizon and 0.1 below; the sun has a radius of 2 degrees and the
// given part of the sky's flux. "half" draws half of the samples each by brightness and by cosine.
//
//                                 cosine   brightness   half   here
//     constant                       0         1.67     0.40    0
//     sky                            0.76      2.0      0.88    0.65
//     sky and sun of 0.3            71         2.4      1.11    0.89
//     sky and sun of 1             260         3.6      1.31    1.54
//     sky and sun of 10           1140        20        1.79    1.90
//     the last, the sun hidden       0.76     32        2.2     2.5
#include <algorithm>
#include <cmath>

#include "common/scene/light_types.h"

namespace tallow {
namespace {

struct Angles {
    Vec2 uv;
    float sine;  // of the angle to +y
};

// u = 1/2 is longitude 0 (+z), longitudes grow towards +x and to the left.
Angles to_angles(const EnvironmentLight& light, Vec3 w) {
    const float sine = std::sqrt(w.x * w.x + w.z * w.z);
    const float u = 0.5f - (std::atan2(w.x, w.z) - light.rotation) / kTwoPi;
    return {{u - std::floor(u), std::atan2(sine, w.y) / kPi}, sine};
}

Vec3 to_direction(const EnvironmentLight& light, Vec2 uv) {
    const float longitude = kTwoPi * (0.5f - uv.x) + light.rotation;
    const float sine = std::sin(kPi * uv.y);
    return {sine * std::sin(longitude), std::cos(kPi * uv.y), sine * std::cos(longitude)};
}

Vec3 cosine_direction(Vec3 n, Vec2 u) {
    // 1 - u.x lies in (0, 1], so that the cosine is never zero.
    const float cosine = std::sqrt(1 - u.x), sine = std::sqrt(u.x), phi = kTwoPi * u.y;
    return glm::normalize(
        make_frame(n).to_world({sine * std::cos(phi), sine * std::sin(phi), cosine}));
}

float even_density(const Normal& n, Vec3 w) {
    return n ? std::max(0.0f, glm::dot(w, *n)) * kInvPi : 1 / (4 * kPi);
}

// Over solid angle: du dv = d omega / (2 pi^2 sine). At the poles themselves nothing is lost.
float mixed_density(float share, const LightImage::Texel& texel, float sine, float even) {
    const float table = texel.density / (2 * kPi * kPi * std::max(sine, 1e-6f));
    return share * table + (1 - share) * even;
}

struct Drawn {
    Vec3 w;
    Rgb radiance;  // over the pdf
};

/// One direction: with probability share() from the picture's table, otherwise evenly, which is by
/// cosine around n or, without n, from all directions. Over the density of both together.
Drawn draw(const EnvironmentLight& light, const Normal& n, Vec2 u) {
    const float share = light.image ? light.image->share() : 0;
    const bool from_table = u.x < share;
    u.x = from_table ? u.x / share : std::min((u.x - share) / (1 - share), 0x1.fffffep-1f);
    Vec3 w;
    if (from_table)
        w = to_direction(light, light.image->draw(u));
    else
        w = n ? cosine_direction(*n, u) : any_direction(u);
    if (!light.image) return {w, light.radiance / even_density(n, w)};
    const auto [uv, sine] = to_angles(light, w);
    const LightImage::Texel texel = light.image->at(uv);
    return {w,
            light.radiance * texel.color / mixed_density(share, texel, sine, even_density(n, w))};
}

}  // namespace

Sample sample(const EnvironmentLight& light, Vec3, const Normal& n, Vec2 u) {
    const Drawn drawn = draw(light, n, u);
    if (max_channel(drawn.radiance) == 0 || (n && glm::dot(drawn.w, *n) <= 0)) return std::nullopt;
    return LightSample{drawn.w, kInfinity, drawn.radiance};
}

float density(const EnvironmentLight& light, Vec3, const Normal& n, Vec3 w) {
    if (n && glm::dot(w, *n) <= 0) return 0;
    if (!light.image) return even_density(n, w);
    const auto [uv, sine] = to_angles(light, w);
    return mixed_density(light.image->share(), light.image->at(uv), sine, even_density(n, w));
}

LightPoint sample_point(const EnvironmentLight& light, Vec2 u) {
    const Drawn drawn = draw(light, std::nullopt, u);
    return {drawn.w, -drawn.w, drawn.radiance, true};
}

Rgb intensity(const EnvironmentLight&, const LightPoint& point, Vec3, float) {
    return point.strength;
}

std::optional<Emission> see(const EnvironmentLight& light, const Ray& ray) {
    if (!light.image) return Emission{kInfinity, light.radiance};
    const Vec2 uv = to_angles(light, ray.direction).uv;
    return Emission{kInfinity, light.radiance * light.image->at(uv).color};
}

}  // namespace tallow
