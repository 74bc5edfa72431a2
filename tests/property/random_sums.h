// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/nbody/kernel_table.h"
#include "tests/support/point_clouds.h"

// Random N-body problems, as unlike each other as their contract allows. Lengths are relative to a
// cloud's `size`, which itself is drawn by the caller.
namespace tallow::test {

/// A kernel in double, and what is needed to tabulate it.
struct RandomKernel {
    std::string name;
    std::function<double(double)> exact;  // r^2 in mm^2 -> 1/mm^2
    double scale;                         // mm
    double negligible;                    // 1/mm^2

    KernelTable table(double unit) const { return {exact, scale, unit, negligible}; }
};

// A share of 0 or 1 now and then, otherwise any order of magnitude from either end.
inline double draw_absorption(Draw& draw) {
    if (draw.one_in(8)) return 0;
    if (draw.one_in(16)) return 1;
    const double small = draw.log_uniform(1e-6, 1);
    return draw.one_in(4) ? 1 - small : small;
}

inline RandomKernel draw_profile(Draw& draw, double mean_free_path) {
    const auto& [name, model] = kModels[draw.below(kModels.size())];
    const double absorption = draw_absorption(draw), eta = draw.uniform(1, 1.5);
    const Medium medium{Rgb(float(absorption / mean_free_path)),
                        Rgb(float((1 - absorption) / mean_free_path)), 0,
                        draw.one_in(8) ? 1 : float(eta)};
    const Orders orders = draw.one_in(2) ? Orders::all : Orders::two_and_more;
    const std::shared_ptr<const Profile> profile = make_profile(model, medium, 0, orders);
    return {fmt::format("{} absorption {} eta {}", name, absorption, medium.eta),
            [profile](double r2) { return (*profile)(r2); }, mean_free_path,
            1e-12 * profile->total_reflectance() / (mean_free_path * mean_free_path)};
}

inline RandomKernel draw_kernel(Draw& draw, double size) {
    const double scale = size * draw.log_uniform(1e-3, 1e3);
    // Up to where the table cannot hold it any more, or as far as that of a profile.
    const double negligible = draw.one_in(4) ? 0 : 1e-12 / (scale * scale);
    const double s2 = scale * scale;
    switch (draw.below(6)) {
        case 0:
            return {fmt::format("gaussian {}", scale),
                    [s2](double r2) { return std::exp(-r2 / s2) / s2; }, scale, negligible};
        case 1:  // has a cusp, which a spline in r^2 can only approach
            return {fmt::format("exponential {}", scale),
                    [s2](double r2) { return std::exp(-std::sqrt(r2 / s2 + 1e-4)) / s2; }, scale,
                    negligible};
        default:
            return draw_profile(draw, scale);
    }
}

inline std::vector<DVec3> draw_shape(Draw& draw, std::size_t n, std::string& name) {
    std::vector<DVec3> points(n);
    const std::uint32_t kind = draw.below(6);
    const double flat = draw.log_uniform(1e-6, 1);
    const DVec3 axis = draw.direction();
    std::vector<DVec3> centers(1 + draw.below(8));
    for (DVec3& c : centers) c = draw.in_box();
    const double radius = draw.log_uniform(1e-4, 0.3);
    static constexpr const char* kNames[] = {"box",       "sphere",    "clusters",
                                             "collinear", "flat disc", "duplicates"};
    name = kNames[kind];
    for (DVec3& p : points) {
        const DVec3 d = draw.direction(), q = draw.in_box();
        const double t = draw.uniform(-1, 1);
        const DVec3 center = centers[draw.below(std::uint32_t(centers.size()))];
        const DVec3 shapes[] = {
            q, d, center + radius * q * glm::dot(q, q), t * axis, {q.x, q.y, flat * q.z}, center};
        p = shapes[kind];
    }
    return points;
}

inline std::vector<float> draw_weights(Draw& draw, std::size_t n) {
    std::vector<float> weights(n);
    const std::uint32_t kind = draw.below(4);
    const double scale = draw.log_uniform(1e-6, 1e6);
    for (float& w : weights) {
        const double x = draw.uniform();
        const double heavy = std::min(1e6, std::pow(x + 1e-9, -1.5));
        const double kinds[] = {1, x, heavy, x < 0.7 ? 0 : x};
        w = float(scale * kinds[kind]);
    }
    return weights;
}

/// Weighted points of a problem, and where it is.
struct RandomCloud {
    std::string name;
    WeightedCloud cloud;
    DVec3 origin;
    double size;
};

inline RandomCloud draw_cloud(Draw& draw, double size, std::size_t n) {
    RandomCloud result{{}, {}, DVec3(0), size};
    const std::vector<DVec3> shape = draw_shape(draw, n, result.name);
    // So far away, positions have few bits left that differ.
    if (draw.one_in(4)) result.origin = size * draw.log_uniform(1, 1e6) * draw.direction();
    std::vector<Vec3> positions;
    for (const DVec3& p : shape) positions.push_back(Vec3(result.origin + size * p));
    result.cloud = sorted_cloud(positions, draw_weights(draw, n));
    result.name +=
        fmt::format(" of {} points, size {}, at distance {}", n, size, glm::length(result.origin));
    return result;
}

/// On samples, beside them, in a ball around them, or so far away that hardly anything arrives.
inline std::vector<Vec3> draw_targets(Draw& draw, const RandomCloud& cloud, double range,
                                      std::size_t n) {
    std::vector<Vec3> targets;
    const std::uint32_t kind = draw.below(5);
    const double aside = cloud.size * draw.log_uniform(1e-5, 1);
    const DVec3 away = draw.direction();
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t j = draw.below(std::uint32_t(cloud.cloud.positions.size()));
        const DVec3 sample(cloud.cloud.positions[j]), d = draw.direction(), q = draw.in_box();
        const DVec3 kinds[] = {sample, sample + aside * d, cloud.origin + 2 * cloud.size * q,
                               cloud.origin + cloud.size * (5.0 * away + q),
                               sample + range * draw.uniform(0, 1.2) * d};
        targets.push_back(Vec3(kinds[kind]));
    }
    return targets;
}

}  // namespace tallow::test
