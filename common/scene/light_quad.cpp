// SPDX-License-Identifier: Apache-2.0
// Quads. Nearby ones are drawn by solid angle, so that near and far parts, seen at a slant or not,
// all bring the same; others by area, which is then almost the same and cheaper; textured ones by
// area and brightness.
#include <algorithm>
#include <cmath>

#include "common/scene/light_types.h"

namespace tallow {
namespace {

/// Area over squared distance to the nearest point from which a quad is drawn by solid angle.
/// Chosen: noise of 16 samples, on a surface that faces a square of side 1 at a distance h,
///
///     h              0.03      0.1      0.3      1        2
///     by area        260 %    67 %     10 %     0.7 %    0.2 %      0.1 us a sample
///     solid angle      3.5     2.7      1.2     0.2      0.04       0.5 us
constexpr float kNear = 0.5f;

bool is_near(const QuadLight& light, Vec3 x) {
    const float width = glm::length(light.u), height = glm::length(light.v);
    const Vec3 to_x = x - light.center;
    const float a = std::max(0.0f, std::abs(glm::dot(to_x, light.u / width)) - width / 2);
    const float b = std::max(0.0f, std::abs(glm::dot(to_x, light.v / height)) - height / 2);
    const float c = glm::dot(to_x, light.normal);
    return width * height > kNear * (a * a + b * b + c * c);
}

/// The texture's point at center + a u + b v.
Vec2 texture_uv(float a, float b) { return {0.5f - a, 0.5f - b}; }

/// A rectangle as seen from a point: edges along the x and y axes, in the plane z < 0.
///
/// Source   Urena, Fajardo, King 2013, "An Area-Preserving Parametrization for Spherical
///          Rectangles"; in double.
class SphericalRectangle {
public:
    SphericalRectangle(double x0, double x1, double y0, double y1, double z)
        : x0_(x0), x1_(x1), y0_(y0), y1_(y1), z_(z) {
        // Normals of the planes through the edges have no component along their edge: of the lower
        // and upper one (0, z, -y), of the right and left one (z, 0, -x), up to their signs.
        const auto z_of_normal = [&](double edge) { return edge / std::hypot(edge, z); };
        b0_ = -z_of_normal(y0), b1_ = z_of_normal(y1);
        const double right = z_of_normal(x1), left = -z_of_normal(x0);
        const auto angle = [](double a, double b) { return std::acos(-a * b); };
        k_ = 2 * std::numbers::pi - angle(b1_, left) - angle(left, b0_);
        solid_angle_ = angle(b0_, right) + angle(right, b1_) - k_;
    }

    double solid_angle() const { return solid_angle_; }

    /// (x, y) in the plane, uniform over the solid angle.
    glm::dvec2 draw(Vec2 u) const {
        const double a = u.x * solid_angle_ + k_;
        const double f = (std::cos(a) * b0_ - b1_) / std::sin(a);
        const double c = std::clamp(std::copysign(1 / std::hypot(f, b0_), f), -1.0, 1.0);
        const double x = std::clamp(-c * z_ / std::sqrt(std::max(1e-30, 1 - c * c)), x0_, x1_);
        const double d = std::hypot(x, z_);
        const double h0 = y0_ / std::hypot(d, y0_), h1 = y1_ / std::hypot(d, y1_);
        const double h = h0 + u.y * (h1 - h0);
        return {x, std::clamp(h * d / std::sqrt(std::max(1e-30, 1 - h * h)), y0_, y1_)};
    }

private:
    double x0_, x1_, y0_, y1_, z_;
    double b0_, b1_, k_, solid_angle_;
};

/// A quad from a point on its lit side: unit edges, the distance behind it, and what it covers.
struct SeenQuad {
    DVec3 right, up;
    double z;
    SphericalRectangle rectangle;
};

std::optional<SeenQuad> seen_from(const QuadLight& light, Vec3 x) {
    const DVec3 to_center = DVec3(light.center) - DVec3(x);
    const double z = glm::dot(to_center, DVec3(light.normal));  // < 0 on the side that is lit
    if (z >= 0) return std::nullopt;
    const double width = glm::length(DVec3(light.u)), height = glm::length(DVec3(light.v));
    const DVec3 right = DVec3(light.u) / width, up = DVec3(light.v) / height;
    const double a = glm::dot(to_center, right), b = glm::dot(to_center, up);
    const SphericalRectangle seen(a - width / 2, a + width / 2, b - height / 2, b + height / 2, z);
    if (!(seen.solid_angle() > 0)) return std::nullopt;
    return SeenQuad{right, up, z, seen};
}

Sample sample_near(const QuadLight& light, Vec3 x, Vec2 u) {
    const auto quad = seen_from(light, x);
    if (!quad) return std::nullopt;
    const auto& [right, up, z, seen] = *quad;
    const glm::dvec2 p = seen.draw(u);
    const DVec3 way = p.x * right + p.y * up + z * DVec3(light.normal);
    const double distance = glm::length(way);
    if (!(distance > 0 && std::isfinite(distance))) return std::nullopt;  // x is on the quad
    return LightSample{Vec3(way / distance), float(distance),
                       float(seen.solid_angle()) * light.radiance};
}

struct Crossing {
    float t;  // mm
    Vec2 uv;  // of the texture
};

/// Where a ray meets the quad's lit side.
std::optional<Crossing> cross(const QuadLight& light, const Ray& ray) {
    const auto t = cross_plane(light.center, light.normal, ray);
    if (!t) return std::nullopt;
    const Vec3 offset = ray.origin + *t * ray.direction - light.center;
    const float a = glm::dot(offset, light.u) / length2(light.u);
    const float b = glm::dot(offset, light.v) / length2(light.v);
    if (std::abs(a) > 0.5f || std::abs(b) > 0.5f) return std::nullopt;
    return Crossing{*t, texture_uv(a, b)};
}

}  // namespace

LightPoint sample_point(const QuadLight& light, Vec2 u) {
    const float area = glm::length(glm::cross(light.u, light.v));
    const auto at = [&](Vec2 ab, Rgb strength) {
        return LightPoint{light.center + ab.x * light.u + ab.y * light.v, light.normal, strength};
    };
    if (!light.texture) return at(u - 0.5f, area * light.radiance);
    // One sample with the density share * table + (1 - share) * uniform, over the unit square.
    const float share = light.texture->share();
    const bool from_table = u.x < share;
    u.x = from_table ? u.x / share : (u.x - share) / (1 - share);
    const Vec2 uv = from_table ? light.texture->draw(u) : u;
    const LightImage::Texel texel = light.texture->at(uv);
    const float density = share * texel.density + (1 - share);
    return at(0.5f - uv, area / density * (light.radiance * texel.color));
}

Sample sample(const QuadLight& light, Vec3 x, const Normal&, Vec2 u) {
    if (!light.texture && is_near(light, x)) return sample_near(light, x, u);
    const LightPoint p = sample_point(light, u);
    return from_area(x, p.position, p.axis, p.strength);
}

Rgb intensity(const QuadLight&, const LightPoint& point, Vec3 w, float) {
    return cosine_intensity(point, w);
}

std::optional<Emission> see(const QuadLight& light, const Ray& ray) {
    const auto crossing = cross(light, ray);
    if (!crossing) return std::nullopt;
    if (!light.texture) return Emission{crossing->t, light.radiance};
    return Emission{crossing->t, light.radiance * light.texture->at(crossing->uv).color};
}

float density(const QuadLight& light, Vec3 x, const Normal&, Vec3 w) {
    const auto crossing = cross(light, {x, w});
    if (!crossing) return 0;
    if (!light.texture && is_near(light, x)) {
        const auto quad = seen_from(light, x);
        return quad ? float(1 / quad->rectangle.solid_angle()) : 0;
    }
    const float area = glm::length(glm::cross(light.u, light.v));
    const float even = area_density(area, crossing->t, w, light.normal);
    if (!light.texture) return even;
    const float share = light.texture->share();
    return even * (share * light.texture->at(crossing->uv).density + (1 - share));
}

}  // namespace tallow
