// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/surface_clusters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/parallel.h"

namespace tallow {
namespace {

// Normals of a patch differ by at most so much in any of x, y, z. Chosen: patches do not reach
// around edges, and a smooth surface of many patches is not cut for its curvature.
constexpr float kMostNormalExtent = 0.8f;

// Halving leaves patches of half to all of the area at which it stops: their mean.
constexpr double kMeanOfHalving = 0.72;

struct Range {
    std::uint32_t begin, end;
};

class Splitter {
public:
    Splitter(const SampledSurface& samples, double largest_area, std::vector<std::uint32_t>& order)
        : samples_(samples), largest_area_(largest_area), order_(order) {}

    /// The range in two parts, or alone, if it is small enough.
    std::vector<Range> split(Range range) const {
        const Extent normals = widest(range, samples_.normal);
        const bool edge = normals.length > kMostNormalExtent;
        if (range.end - range.begin < 2 || (!edge && area(range) <= largest_area_)) return {range};
        const auto begin = order_.begin() + range.begin, end = order_.begin() + range.end;
        // A large patch is halved in space first: most of what differs in it lies far apart.
        const bool by_normal = edge && area(range) <= 2 * largest_area_;
        const auto middle = by_normal
                                ? part_normals(begin, end, normals)
                                : part_positions(begin, end, widest(range, samples_.position).axis);
        const auto cut = std::uint32_t(middle - order_.begin());
        return {Range{range.begin, cut}, Range{cut, range.end}};
    }

private:
    using Iterator = std::vector<std::uint32_t>::iterator;
    struct Extent {
        int axis;
        float length, middle;
    };

    double area(Range range) const {
        double sum = 0;
        for (std::uint32_t i = range.begin; i < range.end; ++i)
            sum += double(samples_.area[order_[i]]);
        return sum;
    }
    Extent widest(Range range, std::span<const Vec3> values) const {
        Vec3 low = values[order_[range.begin]], high = low;
        for (std::uint32_t i = range.begin; i < range.end; ++i) {
            low = glm::min(low, values[order_[i]]);
            high = glm::max(high, values[order_[i]]);
        }
        const Vec3 size = high - low;
        int axis = size.x >= size.y ? 0 : 1;
        if (size.z > size[axis]) axis = 2;
        return {axis, size[axis], (low[axis] + high[axis]) / 2};
    }
    Iterator part_normals(Iterator begin, Iterator end, const Extent& extent) const {
        return std::stable_partition(begin, end, [&](std::uint32_t i) {
            return samples_.normal[i][extent.axis] < extent.middle;
        });
    }
    // Samples of a surface have nearly equal areas: as many on each side as on the other.
    Iterator part_positions(Iterator begin, Iterator end, int axis) const {
        const auto middle = begin + (end - begin) / 2;
        std::nth_element(begin, middle, end, [&](std::uint32_t a, std::uint32_t b) {
            const float u = samples_.position[a][axis], v = samples_.position[b][axis];
            return u < v || (u == v && a < b);
        });
        return middle;
    }

    const SampledSurface& samples_;
    double largest_area_;
    std::vector<std::uint32_t>& order_;
};

// Halves all ranges, level by level, until none is too large.
std::vector<Range> split_all(const Splitter& splitter, std::uint32_t samples) {
    std::vector<Range> ranges{{0, samples}};
    for (;;) {
        std::vector<std::vector<Range>> parts(ranges.size());
        parallel_for(ranges.size(), 1,
                     [&](std::size_t i) { parts[i] = splitter.split(ranges[i]); });
        std::vector<Range> next;
        for (const auto& part : parts) next.insert(next.end(), part.begin(), part.end());
        if (next.size() == ranges.size()) return ranges;
        ranges = std::move(next);
    }
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
    clusters.nearest[cluster] = nearest;
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
    const Splitter splitter(samples, area / (kMeanOfHalving * double(count)), clusters.order);
    std::vector<Range> ranges;
    if (samples.size() > 0) ranges = split_all(splitter, std::uint32_t(samples.size()));
    for (const Range& range : ranges) clusters.first.push_back(range.begin);
    clusters.first.push_back(std::uint32_t(samples.size()));
    const std::size_t n = ranges.size();
    clusters.nearest.resize(n);
    clusters.position.resize(n), clusters.normal.resize(n), clusters.centroid.resize(n);
    clusters.vector_area.resize(n), clusters.area.resize(n);
    parallel_for(n, 16, [&](std::size_t i) { describe(samples, clusters, i); });
    clusters.size = n > 0 ? std::sqrt(area / double(n)) : 0;
    return clusters;
}

}  // namespace tallow
