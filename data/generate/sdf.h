// SPDX-License-Identifier: Apache-2.0
//
// Modelling clay for implicit surfaces: vectors, primitives, and soft boolean operations.
//
// A shape is a function p -> d with d < 0 inside, d > 0 outside. Distances are exact or close to it
// near the surface, which is all that blending, carving and meshing ask for. Lengths are in mm.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace tallow::sculpt {

struct Vec {
    double x = 0, y = 0, z = 0;
};

inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(Vec a) { return std::sqrt(dot(a, a)); }
inline Vec normalized(Vec a) { return (1 / length(a)) * a; }
inline Vec cross(Vec a, Vec b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Orthonormal axes and an origin; `local` maps world coordinates into them, `world` back.
struct Frame {
    Vec origin, x, y, z;

    Vec local(Vec p) const {
        const Vec q = p - origin;
        return {dot(q, x), dot(q, y), dot(q, z)};
    }
    Vec world(Vec q) const { return origin + q.x * x + q.y * y + q.z * z; }
};

/// Frame whose z axis is `forward` and whose y axis is as close to `up` as that allows.
inline Frame look_along(Vec origin, Vec forward, Vec up) {
    const Vec z = normalized(forward);
    const Vec x = normalized(cross(up, z));
    return {origin, x, cross(z, x), z};
}

/// 0 below `a`, 1 above `b`, a cubic with level ends in between.
inline double smooth_step(double a, double b, double t) {
    const double u = std::clamp((t - a) / (b - a), 0.0, 1.0);
    return u * u * (3 - 2 * u);
}

/// Bump of height 1 at t = 0 that is exactly 0 for |t| >= 1, smooth everywhere.
inline double bump(double t) {
    const double u = std::max(0.0, 1 - t * t);
    return u * u * u;
}

/// Union whose seam is filled over a width of about `k`, with continuous curvature, so that no
/// highlight breaks at the edge of the fillet. Equal to min(a, b) where |a - b| >= k: a part
/// farther away than `d + k` need not be evaluated at all.
inline double smooth_union(double a, double b, double k) {
    const double h = std::max(0.0, 1 - std::abs(a - b) / k);
    return std::min(a, b) - k * h * h * h / 6;
}

inline double smooth_intersection(double a, double b, double k) { return -smooth_union(-a, -b, k); }

/// `a` with `b` cut away.
inline double smooth_difference(double a, double b, double k) {
    return smooth_intersection(a, -b, k);
}

/// Ellipsoid at the origin with semi-axes r; first-order distance, exact on the surface.
inline double ellipsoid(Vec p, Vec r) {
    const Vec u{p.x / r.x, p.y / r.y, p.z / r.z};
    const Vec v{u.x / r.x, u.y / r.y, u.z / r.z};
    const double a = length(u), b = length(v);
    return b > 0 ? a * (a - 1) / b : -std::min({r.x, r.y, r.z});
}

/// Cylinder along z at the origin, |z| <= half_height, with its edges rounded by `rounding`.
inline double rounded_cylinder(Vec p, double radius, double half_height, double rounding) {
    const double a = std::hypot(p.x, p.y) - radius + rounding;
    const double b = std::abs(p.z) - half_height + rounding;
    return std::min(std::max(a, b), 0.0) + std::hypot(std::max(a, 0.0), std::max(b, 0.0)) -
           rounding;
}

/// A limb: a tube of varying radius along a uniform cubic B-spline, which has continuous curvature
/// and therefore shows no creases. It starts and ends at the first and last knot, with round caps.
class Limb {
public:
    struct Knot {
        Vec p;
        double r;
    };
    struct Nearest {
        double distance;  // to the tube's surface, negative inside
        double s;         // arc length from the first knot to the nearest point of the axis
        Vec axis;         // that point
        double radius;    // tube radius there
    };

    explicit Limb(std::vector<Knot> knots) : knots_(std::move(knots)) {
        const int n = static_cast<int>(knots_.size()) - 1;
        for (int i = 0; i <= n * kSamples; ++i) {
            const Knot k = at(double(i) / kSamples);
            arc_.push_back(i == 0 ? 0 : arc_.back() + length(k.p - axis_.back()));
            axis_.push_back(k.p);
            center_ = center_ + k.p;
        }
        center_ = (1.0 / double(axis_.size())) * center_;
        for (int i = 0; i <= n * kSamples; ++i)
            reach_ = std::max(reach_, length(axis_[i] - center_) + at(double(i) / kSamples).r);
    }

    /// Never more than the true distance to the tube; cheap.
    double lower_bound(Vec p) const { return length(p - center_) - reach_; }

    Nearest nearest(Vec p) const {
        std::size_t best = 0;
        double best_d2 = 1e300;
        for (std::size_t i = 0; i < axis_.size(); ++i) {
            const Vec q = p - axis_[i];
            if (const double d2 = dot(q, q); d2 < best_d2) best = i, best_d2 = d2;
        }
        const double last = double(knots_.size() - 1);
        double t = double(best) / kSamples;
        for (int i = 0; i < 4; ++i) {  // Newton on (c(t) - p) . c'(t) = 0
            const Vec c = at(t).p - p, d1 = derivative(t), d2 = second_derivative(t);
            const double slope = std::max(dot(d1, d1) + dot(c, d2), 0.25 * dot(d1, d1));
            t = std::clamp(t - dot(c, d1) / slope, 0.0, last);
        }
        const Knot k = at(t);
        const double u = std::min(t * kSamples, double(axis_.size()) - 1.000001);
        const std::size_t i = static_cast<std::size_t>(u);
        const double s = arc_[i] + (u - double(i)) * (arc_[i + 1] - arc_[i]);
        return {length(p - k.p) - k.r, s, k.p, k.r};
    }

    /// Points along the axis, evenly spaced in the spline's parameter.
    const std::vector<Vec>& axis() const { return axis_; }
    double arc_length() const { return arc_.back(); }
    Vec end() const { return axis_.back(); }
    Vec end_direction() const { return normalized(derivative(double(knots_.size() - 1))); }

private:
    static constexpr int kSamples = 8;  // coarse samples per knot; only starts Newton's method

    /// Control point i, with phantom points mirrored past both ends. Their radii make the tube end
    /// with constant radius, so that it meets its round cap without a crease.
    Knot control(int i) const {
        const int n = static_cast<int>(knots_.size()) - 1;
        if (i < 0) return mirrored(knots_[0], knots_[1]);
        if (i > n) return mirrored(knots_[n], knots_[n - 1]);
        return knots_[i];
    }
    static Knot mirrored(const Knot& a, const Knot& b) { return {2 * a.p - b.p, b.r}; }

    /// Sum of the four control points around t with the weights w[0..3].
    Knot blend(int i, const double (&w)[4]) const {
        Knot sum{{}, 0};
        for (int j = 0; j < 4; ++j) {
            const Knot k = control(i + j - 1);
            sum.p = sum.p + w[j] * k.p;
            sum.r += w[j] * k.r;
        }
        return sum;
    }
    int span(double t) const {
        return std::min(static_cast<int>(t), static_cast<int>(knots_.size()) - 2);
    }
    Knot at(double t) const {
        const int i = span(t);
        const double u = t - i, v = 1 - u;
        return blend(i, {v * v * v / 6, (4 - 6 * u * u + 3 * u * u * u) / 6,
                         (4 - 6 * v * v + 3 * v * v * v) / 6, u * u * u / 6});
    }
    Vec derivative(double t) const {
        const int i = span(t);
        const double u = t - i, v = 1 - u;
        return blend(i, {-v * v / 2, (3 * u * u - 4 * u) / 2, (4 * v - 3 * v * v) / 2, u * u / 2})
            .p;
    }
    Vec second_derivative(double t) const {
        const int i = span(t);
        const double u = t - i;
        return blend(i, {1 - u, 3 * u - 2, 1 - 3 * u, u}).p;
    }

    std::vector<Knot> knots_;
    std::vector<Vec> axis_;    // axis_[kSamples * knot + sample]
    std::vector<double> arc_;  // arc length at axis_[i]
    Vec center_;
    double reach_ = 0;
};

/// A closed outline in the plane, given by a few control points and smoothed by a cubic B-spline.
/// Only x and y of the control points are used.
class Outline {
public:
    explicit Outline(const std::vector<Vec>& control) {
        const std::size_t n = control.size();
        for (std::size_t i = 0; i < n; ++i)
            for (int j = 0; j < kSamples; ++j) {
                const double u = double(j) / kSamples, v = 1 - u;
                points_.push_back((v * v * v / 6) * control[i] +
                                  ((4 - 6 * u * u + 3 * u * u * u) / 6) * control[(i + 1) % n] +
                                  ((4 - 6 * v * v + 3 * v * v * v) / 6) * control[(i + 2) % n] +
                                  (u * u * u / 6) * control[(i + 3) % n]);
            }
    }

    /// Signed distance in the plane, negative inside.
    double distance(double x, double y) const {
        double d2 = 1e300;
        bool inside = false;
        for (std::size_t i = 0, j = points_.size() - 1; i < points_.size(); j = i++) {
            const Vec a = points_[i], b = points_[j];
            const double ex = b.x - a.x, ey = b.y - a.y, px = x - a.x, py = y - a.y;
            const double t = std::clamp((px * ex + py * ey) / (ex * ex + ey * ey), 0.0, 1.0);
            const double qx = px - t * ex, qy = py - t * ey;
            d2 = std::min(d2, qx * qx + qy * qy);
            if ((a.y > y) != (b.y > y) && px < ex * py / ey) inside = !inside;
        }
        return inside ? -std::sqrt(d2) : std::sqrt(d2);
    }

private:
    static constexpr int kSamples = 6;
    std::vector<Vec> points_;
};

/// A line engraved into a surface along a chain of points, fading out towards both ends.
class Groove {
public:
    Groove(std::vector<Vec> points, double width, double depth)
        : points_(std::move(points)), width_(width), depth_(depth) {
        for (const Vec p : points_) center_ = center_ + p;
        center_ = (1.0 / double(points_.size())) * center_;
        for (const Vec p : points_) reach_ = std::max(reach_, length(p - center_) + width_);
    }

    /// Amount to add to the distance function at p, in [0, depth].
    double depth(Vec p) const {
        const Vec q = p - center_;
        if (dot(q, q) >= reach_ * reach_) return 0;
        double best = 1e300, where = 0;
        for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
            const Vec ab = points_[i + 1] - points_[i], ap = p - points_[i];
            const double t = std::clamp(dot(ap, ab) / dot(ab, ab), 0.0, 1.0);
            if (const double d = length(ap - t * ab); d < best) best = d, where = double(i) + t;
        }
        const double u = 2 * where / double(points_.size() - 1) - 1;  // -1 and 1 at the ends
        const double fade = 1 - u * u;
        return depth_ * fade * bump(best / (width_ * (0.5 + 0.5 * fade)));
    }

private:
    std::vector<Vec> points_;
    double width_, depth_;
    Vec center_;
    double reach_ = 0;
};

}  // namespace tallow::sculpt
