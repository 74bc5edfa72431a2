// SPDX-License-Identifier: Apache-2.0
// Rays and a sphere; the path through it to a fixed point, as one equation in the plane of
// incidence.
#include "experiments/reference/sphere_body.h"

#include <algorithm>
#include <cmath>

namespace tallow::reference {
namespace {

// Part of the way to the first caustic up to which a link counts. Chosen: the spread is then at
// most 3 x 3 times that of a sphere without curvature.
constexpr double kOfCaustic = 0.7;

/// Distances along a ray to the two crossings, smaller first; nothing if it misses.
struct Roots {
    double near, far;
};
std::optional<Roots> cross(DVec3 to_origin, DVec3 direction, double radius) {
    const double b = glm::dot(to_origin, direction);
    const double closest2 = glm::dot(to_origin, to_origin) - b * b;
    const double discriminant = radius * radius - closest2;
    if (!(discriminant > 0)) return std::nullopt;
    const double half = std::sqrt(discriminant);
    return Roots{-b - half, -b + half};
}

/// The plane through the centre, x and the camera y: x at angle 0 and distance r, y at angle beta
/// and distance Y, lengths in radii.
struct PlaneOfIncidence {
    double eta, r, Y, beta;

    struct Value {
        double f, slope;
    };
    /// sin_o - eta sin_i at the point of the sphere at angle phi, and its derivative.
    Value operator()(double phi) const {
        const double s = std::sin(phi), c = std::cos(phi);
        const double s_o = std::sin(beta - phi), c_o = std::cos(beta - phi);
        const double d_i = std::sqrt(1 + r * (r - 2 * c)), d_o = std::sqrt(1 + Y * (Y - 2 * c_o));
        const double f = Y * s_o / d_o - eta * r * s / d_i;
        // d/dphi (s / d) = c / d - r s^2 / d^3
        const double outer = -(Y * c_o / d_o - Y * Y * s_o * s_o / (d_o * d_o * d_o));
        const double inner = eta * (r * c / d_i - r * r * s * s / (d_i * d_i * d_i));
        return {f, outer - inner};
    }
};

/// A root of f between low (f > 0) and high (f < 0): Newton's method, kept inside by bisection.
double bracketed_root(const PlaneOfIncidence& f, double low, double high, double start) {
    constexpr int kMost = 60;
    double phi = start;
    for (int i = 0; i < kMost; ++i) {
        const auto [value, slope] = f(phi);
        (value > 0 ? low : high) = phi;
        double next = phi - value / slope;
        if (!(next > low && next < high)) next = (low + high) / 2;
        const double step = std::abs(next - phi);
        phi = next;
        if (step < 1e-13) break;
    }
    return phi;
}

}  // namespace

Crossing SphereBody::crossing(Vec3 origin, Vec3 direction, double t) const {
    const DVec3 from_center = DVec3(origin) + t * DVec3(direction) - center_;
    const DVec3 normal = glm::normalize(from_center);
    return {float(t), Vec3(center_ + radius_ * normal), Vec3(normal), 0};
}

std::optional<Crossing> SphereBody::enter(Vec3 origin, Vec3 direction, float length) const {
    const DVec3 to_origin = DVec3(origin) - center_;
    if (glm::dot(to_origin, DVec3(direction)) >= 0) return std::nullopt;  // going away
    const std::optional<Roots> roots = cross(to_origin, DVec3(direction), radius_);
    if (!roots || roots->near > double(length)) return std::nullopt;
    return crossing(origin, direction, std::max(0.0, roots->near));
}

std::optional<Crossing> SphereBody::leave(Vec3 origin, Vec3 direction, float length) const {
    // A start on the surface is moved inwards by its rounding: along the surface, too, there is
    // then some way to go, or a walk could be reflected on the spot for ever.
    constexpr double kInside = 1 - 1e-7;
    const DVec3 to_origin = DVec3(origin) - center_;
    const double beyond = glm::length(to_origin) / (kInside * radius_);
    const DVec3 start = beyond > 1 ? to_origin / beyond : to_origin;
    const std::optional<Roots> roots = cross(start, DVec3(direction), radius_);
    if (!roots || roots->far > double(length)) return std::nullopt;
    return crossing(Vec3(center_ + start), direction, roots->far);
}

float SphereBody::clearance(Vec3 x) const {
    constexpr double kRounding = 1e-5;  // points on the surface are not outside
    const double depth = radius_ - glm::length(DVec3(x) - center_);
    return float(depth < -kRounding * radius_ ? depth : std::max(0.0, depth));
}

std::optional<CameraLink> SphereBody::find_link(Vec3 x, float reach) const {
    const DVec3 to_x = (DVec3(x) - center_) / radius_, to_y = (camera_ - center_) / radius_;
    const double r = glm::length(to_x), Y = glm::length(to_y);
    if (!(r < 1) || !(r > 0)) return std::nullopt;
    const DVec3 axis = to_x / r;
    const DVec3 off_axis = to_y - glm::dot(to_y, axis) * axis;
    const double sine = glm::length(off_axis);
    const double beta = std::atan2(sine, glm::dot(to_y, axis));
    // The camera sees points of the sphere up to this angle from its own direction.
    const double low = std::max(0.0, beta - std::acos(1 / Y));
    if (low >= beta && beta > 0) return std::nullopt;
    // No path is shorter than the way from x straight up, or to where the camera's horizon begins.
    const double shortest = std::sqrt(1 + r * (r - 2 * std::cos(low))) * radius_;
    if (shortest > double(reach)) return std::nullopt;
    const PlaneOfIncidence f{eta_, r, Y, beta};
    const auto [at_low, slope] = f(low);
    if (beta > 0 && !(at_low > 0)) return std::nullopt;
    const double start = std::clamp(low - at_low / slope, low, beta);
    const double phi = beta > 0 ? bracketed_root(f, low, beta, start) : 0;
    const DVec3 across = sine > 0 ? off_axis / sine : DVec3(0);
    const DVec3 normal = std::cos(phi) * axis + std::sin(phi) * across;

    CameraLink link{};
    link.open = true;
    link.position = center_ + radius_ * normal;
    const DVec3 in = link.position - DVec3(x), out = camera_ - link.position;
    link.inside = glm::length(in), link.outside = glm::length(out);
    link.w = in / link.inside;
    link.cos_in = glm::dot(link.w, normal), link.cos_out = glm::dot(out, normal) / link.outside;
    if (!(link.inside > 0 && link.inside <= double(reach))) return std::nullopt;
    if (!(link.cos_in > 0 && link.cos_out > 0)) return std::nullopt;
    const Pencil pencil(eta_, 1 / radius_, link.outside, link.cos_in, link.cos_out);
    if (link.inside * std::max(pencil.sagittal, pencil.tangential) > kOfCaustic)
        return std::nullopt;
    link.spread = pencil.spread(link.inside, link.outside, link.cos_in, link.cos_out);
    return link;
}

bool SphereBody::links_path(Vec3 x, Vec3 p, float, float reach) const {
    // Different solutions lie farther apart than this unless x is on a caustic; rounding moves the
    // same one by less.
    constexpr double kSame = 1e-3;
    const std::optional<CameraLink> link = find_link(x, reach);
    return link && glm::length(link->position - DVec3(p)) < kSame * radius_;
}

}  // namespace tallow::reference
