// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/surface_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/base/parallel.h"

namespace tallow {
namespace {

// How far apart two normals at a right angle count, in cluster sizes. Chosen: a cluster does not
// reach around an edge, and a smoothly curved surface is still cut by position.
constexpr float kNormalWeight = 2;

struct Range {
    std::uint32_t begin, end;
};

class Splitter {
public:
    Splitter(const SampledSurface& samples, float normal_scale, std::vector<std::uint32_t>& order)
        : samples_(samples), normal_scale_(normal_scale), order_(order) {}

    /// The range in two parts of equal area, of which none is empty.
    std::array<Range, 2> split(Range range) const {
        const int axis = widest(range);
        const auto begin = order_.begin() + range.begin, end = order_.begin() + range.end;
        std::sort(begin, end, [&](std::uint32_t a, std::uint32_t b) {
            const float u = coordinate(a, axis), v = coordinate(b, axis);
            return u < v || (u == v && a < b);
        });
        double half = 0;
        for (auto i = begin; i != end; ++i) half += samples_.area[*i];
        half /= 2;
        auto middle = begin;
        for (double sum = 0; sum < half && middle != end; ++middle) sum += samples_.area[*middle];
        middle = std::clamp(middle, begin + 1, end - 1);
        const auto cut = std::uint32_t(middle - order_.begin());
        return {{{range.begin, cut}, {cut, range.end}}};
    }

private:
    float coordinate(std::uint32_t sample, int axis) const {
        return axis < 3 ? samples_.position[sample][axis]
                        : normal_scale_ * samples_.normal[sample][axis - 3];
    }
    int widest(Range range) const {
        int best = 0;
        float extent = -1;
        for (int axis = 0; axis < 6; ++axis) {
            float low = std::numeric_limits<float>::max(), high = -low;
            for (std::uint32_t i = range.begin; i < range.end; ++i) {
                const float x = coordinate(order_[i], axis);
                low = std::min(low, x), high = std::max(high, x);
            }
            if (high - low > extent) extent = high - low, best = axis;
        }
        return best;
    }

    const SampledSurface& samples_;
    float normal_scale_;
    std::vector<std::uint32_t>& order_;
};

// Halves all ranges, level by level, until there are enough.
std::vector<Range> split_all(const Splitter& splitter, std::uint32_t samples, std::size_t count) {
    std::vector<Range> ranges{{0, samples}};
    while (ranges.size() < count) {
        std::vector<std::array<Range, 2>> halves(ranges.size());
        parallel_for(ranges.size(), 1, [&](std::size_t i) {
            halves[i] = ranges[i].end - ranges[i].begin > 1
                            ? splitter.split(ranges[i])
                            : std::array<Range, 2>{ranges[i], Range{0, 0}};
        });
        std::vector<Range> next;
        for (const auto& [a, b] : halves) {
            next.push_back(a);
            if (b.end > b.begin) next.push_back(b);
        }
        if (next.size() == ranges.size()) break;
        ranges = std::move(next);
    }
    return ranges;
}

void describe(const SampledSurface& samples, SurfaceClusters& clusters, std::size_t cluster) {
    DVec3 centroid(0), vector_area(0);
    double area = 0;
    const auto members = clusters.samples(cluster);
    for (const std::uint32_t s : members) {
        const double A = double(samples.area[s]);
        area += A;
        centroid += A * DVec3(samples.position[s]);
        vector_area += A * DVec3(samples.normal[s]);
    }
    centroid /= area;
    const auto distance = [&](std::uint32_t s) {
        const DVec3 d = DVec3(samples.position[s]) - centroid;
        return glm::dot(d, d);
    };
    const std::uint32_t nearest = *std::min_element(
        members.begin(), members.end(),
        [&](std::uint32_t a, std::uint32_t b) { return distance(a) < distance(b); });
    clusters.position[cluster] = samples.position[nearest];
    clusters.normal[cluster] = samples.normal[nearest];
    clusters.centroid[cluster] = Vec3(centroid);
    clusters.vector_area[cluster] = Vec3(vector_area);
    clusters.area[cluster] = float(area);
}

}  // namespace

SurfaceClusters cluster_surface(const SampledSurface& samples, std::size_t count) {
    SurfaceClusters clusters;
    clusters.order.resize(samples.size());
    std::iota(clusters.order.begin(), clusters.order.end(), 0u);
    double area = 0;
    for (const float a : samples.area) area += double(a);
    const auto normal_scale = float(kNormalWeight * std::sqrt(area / double(count)));
    const Splitter splitter(samples, normal_scale, clusters.order);
    std::vector<Range> ranges;
    if (samples.size() > 0) ranges = split_all(splitter, std::uint32_t(samples.size()), count);
    for (const Range& range : ranges) clusters.first.push_back(range.begin);
    clusters.first.push_back(std::uint32_t(samples.size()));
    const std::size_t n = ranges.size();
    clusters.position.resize(n), clusters.normal.resize(n), clusters.centroid.resize(n);
    clusters.vector_area.resize(n), clusters.area.resize(n);
    parallel_for(n, 16, [&](std::size_t i) { describe(samples, clusters, i); });
    clusters.size = n > 0 ? std::sqrt(area / double(n)) : 0;
    return clusters;
}

}  // namespace tallow
