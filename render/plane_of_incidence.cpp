// SPDX-License-Identifier: Apache-2.0
// Refraction by a plane and by a sphere, which are one-dimensional problems.
#include "render/plane_of_incidence.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tallow {
namespace {

constexpr double kPiDouble = std::numbers::pi;

// Root of a function with values of order 1, f(low) and f(high) of different signs: the Illinois
// variant of regula falsi, with bisection where it is slow.
template <class F>
double root(F&& f, double low, double high) {
    constexpr double kNoise = 1e-15;  // of the sines that f is made of
    double f_low = f(low), f_high = f(high);
    int side = 0;  // which end moved last
    for (int i = 0; i < 100 && high - low > kNoise * (std::abs(low) + std::abs(high)); ++i) {
        double middle = (low * f_high - high * f_low) / (f_high - f_low);
        if (i % 8 == 7 || !(middle > low && middle < high)) middle = (low + high) / 2;
        const double f_middle = f(middle);
        if (std::abs(f_middle) <= kNoise) return middle;
        if ((f_middle > 0) == (f_high > 0)) {
            high = middle, f_high = f_middle;
            if (side > 0) f_low /= 2;
            side = 1;
        } else {
            low = middle, f_low = f_middle;
            if (side < 0) f_high /= 2;
            side = -1;
        }
    }
    return (low + high) / 2;
}

/// A unit sphere seen in the plane of incidence; x at angle 0 and distance r < 1 from the centre,
/// the light at angle beta and distance R > 1.
class UnitCircle {
public:
    UnitCircle(double eta, double r, double beta, double R)
        : eta_(eta), r_(r), beta_(beta), R_(R) {}

    std::vector<double> roots() {
        // The part of the circle that the light sees, cut where sin_t turns.
        const double seen = std::isfinite(R_) ? std::acos(1 / R_) : kPiDouble / 2;
        const double turn = std::acos(r_);
        const double low = beta_ - seen, high = beta_ + seen;
        const double cuts[] = {-2 * kPiDouble + turn, -turn, turn, 2 * kPiDouble - turn};
        for (int i = 0; i < 3; ++i) {
            const double a = std::max(low, cuts[i]), b = std::min(high, cuts[i + 1]);
            if (a < b) search(a, b, kSplits);
        }
        return std::move(roots_);
    }

private:
    static constexpr int kSplits = 15;  // pi / 2^15: 1e-4 rad

    double f_inside(double phi) const {
        return -eta_ * r_ * std::sin(phi) / std::sqrt(1 + r_ * (r_ - 2 * std::cos(phi)));
    }
    double f_outside(double phi) const {
        const double sine = std::sin(beta_ - phi);
        if (!std::isfinite(R_)) return sine;
        return sine / std::sqrt(1 + (1 / R_) * (1 / R_ - 2 * std::cos(beta_ - phi)));
    }
    double f(double phi) const { return f_inside(phi) + f_outside(phi); }

    // Both parts are monotone between a and b.
    void search(double a, double b, int splits) {
        const double in_a = f_inside(a), in_b = f_inside(b);
        const double out_a = f_outside(a), out_b = f_outside(b);
        const double least = std::min(in_a, in_b) + std::min(out_a, out_b);
        const double most = std::max(in_a, in_b) + std::max(out_a, out_b);
        if (least > 0 || most < 0) return;
        const bool same_sense = (in_a > in_b) == (out_a > out_b);
        if (same_sense || splits == 0) {
            if ((in_a + out_a > 0) != (in_b + out_b > 0))
                roots_.push_back(root([this](double phi) { return f(phi); }, a, b));
            return;
        }
        search(a, (a + b) / 2, splits - 1);
        search((a + b) / 2, b, splits - 1);
    }

    double eta_, r_, beta_, R_;
    std::vector<double> roots_;
};

// Distance s from x's foot, of `distance` between the feet of x and y, at which light goes through
// the plane:
//
//     f(s) = eta s / sqrt(s^2 + depth^2) - (distance - s) / sqrt((distance - s)^2 + height^2) = 0
//
// f grows with s: Newton's method from the angle of light at x's foot, inside a shrinking bracket.
double refraction_offset(double eta, double depth, double height, double distance) {
    constexpr int kMost = 100;           // 3 to 5 are usual
    constexpr double kConverged = 1e-6;  // the last step; the error is about its square
    double low = 0, high = distance;
    const double sine = distance / (eta * std::sqrt(distance * distance + height * height));
    double s = sine < 1 ? std::min(distance, depth * sine / std::sqrt(1 - sine * sine)) : distance;
    for (int i = 0; i < kMost; ++i) {
        const double rest = distance - s;
        const double in2 = s * s + depth * depth, out2 = rest * rest + height * height;
        const double in = std::sqrt(in2), out = std::sqrt(out2);
        const double f = eta * s / in - rest / out;
        (f > 0 ? high : low) = s;
        double next = s - f / (eta * depth * depth / (in2 * in) + height * height / (out2 * out));
        const bool inside = next >= low && next <= high;
        if (!inside) next = (low + high) / 2;
        const double step = std::abs(next - s);
        s = next;
        if (step <= (inside ? kConverged : 1e-15) * s) break;
    }
    return s;
}

DVec3 any_perpendicular(DVec3 unit) {
    return glm::normalize(
        glm::cross(unit, std::abs(unit.x) < 0.6 ? DVec3(1, 0, 0) : DVec3(0, 1, 0)));
}

}  // namespace

std::optional<DVec3> refract_through_plane(const Ends& ends, DVec3 point, DVec3 normal) {
    const double depth = -glm::dot(ends.x - point, normal);
    const double height = glm::dot(ends.y_at_infinity ? ends.y : ends.y - point, normal);
    if (!(depth > 0 && height > 0)) return std::nullopt;
    const DVec3 foot = ends.x + depth * normal;
    const DVec3 aside =
        ends.y_at_infinity ? ends.y - height * normal : ends.y - height * normal - foot;
    const double distance = glm::length(aside);
    if (distance == 0) return foot;
    if (ends.y_at_infinity) {
        const double sine = distance / ends.eta;
        return foot + depth * sine / (distance * std::sqrt(1 - sine * sine)) * aside;
    }
    return foot + refraction_offset(ends.eta, depth, height, distance) / distance * aside;
}

std::vector<DVec3> refract_through_sphere(const Ends& ends, DVec3 center, double radius) {
    const DVec3 to_x = (ends.x - center) / radius;
    const DVec3 to_y = ends.y_at_infinity ? ends.y : (ends.y - center) / radius;
    const double r = glm::length(to_x);
    const double R = ends.y_at_infinity ? double(kInfinity) : glm::length(to_y);
    if (!(r < 1 && R > 1)) return {};
    const DVec3 y_axis = glm::normalize(to_y);
    const DVec3 axis = r > 0 ? to_x / r : y_axis;
    const DVec3 rest = y_axis - glm::dot(y_axis, axis) * axis;
    const double sine = glm::length(rest);
    const DVec3 across = sine > 1e-12 ? rest / sine : any_perpendicular(axis);
    const double beta = std::atan2(glm::dot(y_axis, across), glm::dot(y_axis, axis));
    std::vector<DVec3> points;
    for (double phi : UnitCircle(ends.eta, r, beta, R).roots())
        points.push_back(center + radius * (std::cos(phi) * axis + std::sin(phi) * across));
    return points;
}

}  // namespace tallow
