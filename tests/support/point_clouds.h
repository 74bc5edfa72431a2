// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "common/base/vec.h"
#include "common/cloud/morton.h"
#include "precompute/build_octree.h"

// Weighted points for tests of N-body sums, and the sums themselves without any cleverness.
namespace tallow::test {

/// Random numbers in the order in which they are asked for; the same for the same seed.
class Draw {
public:
    explicit Draw(std::uint64_t seed) : seed_(seed) {}

    double uniform() { return random_bits(seed_, 0, index_++) * 0x1p-32; }
    double uniform(double low, double high) { return low + (high - low) * uniform(); }
    double log_uniform(double low, double high) { return low * std::pow(high / low, uniform()); }
    bool one_in(std::uint32_t n) { return below(n) == 0; }
    std::uint32_t below(std::uint32_t n) { return std::uint32_t(uniform() * n); }
    DVec3 in_box() {  // [-1, 1]^3
        const double x = uniform(-1, 1), y = uniform(-1, 1);
        return {x, y, uniform(-1, 1)};
    }
    DVec3 direction() {
        const double z = uniform(-1, 1), phi = 2 * M_PI * uniform(), s = std::sqrt(1 - z * z);
        return {s * std::cos(phi), s * std::sin(phi), z};
    }

private:
    std::uint64_t seed_, index_ = 0;
};

/// Points in Morton order with their weights, and the octree over them.
struct WeightedCloud {
    std::vector<Vec3> positions;  // mm
    std::vector<float> weights;
    std::vector<OctreeNode> nodes;
};

inline WeightedCloud sorted_cloud(std::span<const Vec3> positions, std::span<const float> weights) {
    WeightedCloud cloud;
    for (const std::uint32_t i : sorted_order(morton_codes(positions))) {
        cloud.positions.push_back(positions[i]);
        cloud.weights.push_back(weights[i]);
    }
    cloud.nodes = build_octree(cloud.positions);
    return cloud;
}

/// On a bumpy shell some 10 mm across that is dense at its equator, every fiftieth point twice:
/// what samples of a surface look like, and a little worse.
inline std::vector<Vec3> bumpy_shell(Draw& draw, std::size_t n) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < n; ++i) {
        const DVec3 d = draw.direction();
        const double r = 5 + std::sin(5 * std::atan2(d.y, d.x)) * d.z;
        points.push_back(Vec3(r * DVec3(d.x, d.y, d.z * d.z * d.z)));
    }
    for (std::size_t i = 0; i + 4 < n; i += 50) points[i + 3] = points[i];
    return points;
}

inline std::vector<float> random_weights(Draw& draw, std::size_t n) {
    std::vector<float> weights(n);
    for (float& w : weights) w = float(draw.uniform(0.01, 0.06));
    return weights;
}

/// Sum of w K and of |w K| over all points.
struct DirectSum {
    double sum = 0, absolute = 0;
};

/// Kernel   double(double r2), r2 in mm^2.
template <class Kernel>
DirectSum direct_sum(const WeightedCloud& cloud, Vec3 x, const Kernel& kernel) {
    DirectSum result;
    for (std::size_t j = 0; j < cloud.positions.size(); ++j) {
        const DVec3 d = DVec3(x) - DVec3(cloud.positions[j]);
        const double term = double(cloud.weights[j]) * kernel(glm::dot(d, d));
        result.sum += term;
        result.absolute += std::abs(term);
    }
    return result;
}

template <class Kernel>
std::vector<DirectSum> direct_sums(const WeightedCloud& cloud, std::span<const Vec3> targets,
                                   const Kernel& kernel) {
    std::vector<DirectSum> sums(targets.size());
    parallel_for(targets.size(), 8,
                 [&](std::size_t i) { sums[i] = direct_sum(cloud, targets[i], kernel); });
    return sums;
}

}  // namespace tallow::test
