// SPDX-License-Identifier: Apache-2.0
#include "experiments/sampling/point_sets.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "common/cloud/morton.h"

namespace tallow {
namespace {

/// Draws points uniformly by area.
class PointSource {
public:
    PointSource(const TriangleMesh& mesh, std::uint64_t seed) : mesh_(mesh), seed_(seed) {
        double sum = 0;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            sums_.push_back(sum += triangle_area(mesh, t));
    }

    double area() const { return sums_.back(); }

    void draw(std::uint64_t i, Vec3& position, Vec3& normal) const {
        const double at = (double(random_bits(seed_, 0, i)) + 0.5) * 0x1p-32 * sums_.back();
        const auto found = std::lower_bound(sums_.begin(), sums_.end(), at);
        const auto t = std::size_t(std::min(found, sums_.end() - 1) - sums_.begin());
        const float root = std::sqrt(to_unit_float(random_bits(seed_, 1, i)));
        const float v = to_unit_float(random_bits(seed_, 2, i));
        const float a = 1 - root, b = root * (1 - v), c = root * v;
        const auto [p, q, r] = mesh_.triangles[t];
        position = a * mesh_.vertices[p] + b * mesh_.vertices[q] + c * mesh_.vertices[r];
        normal = triangle_normal(mesh_, t);
        if (!mesh_.corner_normals.empty())
            normal = glm::normalize(a * mesh_.corner_normals[3 * t] +
                                    b * mesh_.corner_normals[3 * t + 1] +
                                    c * mesh_.corner_normals[3 * t + 2]);
    }

private:
    const TriangleMesh& mesh_;
    std::uint64_t seed_;
    std::vector<double> sums_;
};

/// Points in a hash of cubes.
class PointGrid {
public:
    explicit PointGrid(float side) : side_(side) {}

    void add(Vec3 p, std::uint32_t index) { cubes_[key(cube(p))].push_back(index); }

    /// Calls visit(index) for all points within `side` of p, and some others.
    template <class Visit>
    void around(Vec3 p, const Visit& visit) const {
        const glm::ivec3 middle = cube(p);
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    if (const auto found = cubes_.find(key(middle + glm::ivec3(x, y, z)));
                        found != cubes_.end())
                        for (const std::uint32_t index : found->second) visit(index);
    }

private:
    glm::ivec3 cube(Vec3 p) const { return glm::ivec3(glm::floor(p / side_)); }
    static std::uint64_t key(glm::ivec3 c) {
        return std::uint64_t(c.x & 0x1fffff) << 42 | std::uint64_t(c.y & 0x1fffff) << 21 |
               std::uint64_t(c.z & 0x1fffff);
    }

    float side_;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cubes_;
};

SurfaceSamples in_morton_order(const std::vector<Vec3>& position, const std::vector<Vec3>& normal,
                               double area) {
    SurfaceSamples samples;
    const auto each = float(area / double(position.size()));
    for (const std::uint32_t i : sorted_order(morton_codes(position))) {
        samples.position.push_back(position[i]);
        samples.normal.push_back(normal[i]);
        samples.area.push_back(each);
    }
    samples.ray_origin = samples.position;
    return samples;
}

}  // namespace

SurfaceSamples random_points(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
    const PointSource source(mesh, seed);
    std::vector<Vec3> position(count), normal(count);
    parallel_for(count, 4096, [&](std::size_t i) { source.draw(i, position[i], normal[i]); });
    return in_morton_order(position, normal, source.area());
}

SurfaceSamples blue_noise(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
    const PointSource source(mesh, seed);
    // Random sequential packing of discs jams at 0.547 of the plane, that is 0.697 points a
    // distance^2; 0.6 are there after some ten darts each.
    const auto distance = float(std::sqrt(0.6 * source.area() / double(count)));
    PointGrid grid(distance);
    std::vector<Vec3> position, normal;
    for (std::uint64_t dart = 0; dart < 40 * count && position.size() < count; ++dart) {
        Vec3 p, n;
        source.draw(dart, p, n);
        bool free = true;
        grid.around(p, [&](std::uint32_t i) {
            free = free &&
                   !(length2(position[i] - p) < distance * distance && glm::dot(normal[i], n) > 0);
        });
        if (!free) continue;
        grid.add(p, std::uint32_t(position.size()));
        position.push_back(p);
        normal.push_back(n);
    }
    return in_morton_order(position, normal, source.area());
}

SurfaceSamples with_voronoi_areas(SurfaceSamples points, const SurfaceSamples& fine) {
    // No gap of the points is wider than their distance, which is below 1.3 of this.
    const float side = 1.3f * std::sqrt(points.area[0]);
    PointGrid grid(side);
    for (std::uint32_t i = 0; i < points.size(); ++i) grid.add(points.position[i], i);
    std::vector<std::uint32_t> owner(fine.size());
    parallel_for(fine.size(), 4096, [&](std::size_t k) {
        float least = kInfinity;
        grid.around(fine.position[k], [&](std::uint32_t i) {
            const float d2 = length2(points.position[i] - fine.position[k]);
            if (glm::dot(points.normal[i], fine.normal[k]) <= 0 || d2 >= least) return;
            least = d2;
            owner[k] = i;
        });
        if (least == kInfinity) owner[k] = std::uint32_t(points.size());  // a scrap: left out
    });
    std::vector<double> area(points.size() + 1, 0);
    for (std::size_t k = 0; k < fine.size(); ++k) area[owner[k]] += double(fine.area[k]);
    for (std::size_t i = 0; i < points.size(); ++i) points.area[i] = float(area[i]);
    return points;
}

}  // namespace tallow
