// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.h"

namespace tallow {

/// Samples of a surface: positions [mm], unit normals and exact areas [mm^2], one item a sample.
struct SampledSurface {
    std::span<const Vec3> position;
    std::span<const Vec3> normal;
    std::span<const float> area;

    std::size_t size() const { return position.size(); }
};

/// A surface cut into patches of nearly equal area: neighbours that also face alike, so that the
/// two sides of a thin sheet and of a sharp edge lie in different patches.
struct SurfaceClusters {
    std::vector<std::uint32_t> order;    // samples, cluster by cluster
    std::vector<std::uint32_t> first;    // [cluster + 1] its first sample in order[]
    std::vector<std::uint32_t> nearest;  // [cluster] the sample nearest to the centroid
    std::vector<Vec3> position;          // [cluster] mm, of that sample
    std::vector<Vec3> normal;            // [cluster] unit, of that sample
    std::vector<Vec3> centroid;          // [cluster] mm, weighted by area
    std::vector<Vec3> vector_area;       // [cluster] mm^2, sum of area times normal
    std::vector<float> area;             // [cluster] mm^2
    double size = 0;                     // mm, root of the mean area

    std::size_t count() const { return area.size(); }
    std::span<const std::uint32_t> samples(std::size_t cluster) const {
        return std::span(order).subspan(first[cluster], first[cluster + 1] - first[cluster]);
    }
};

/// Halves the samples, until no patch has much more than a `count`-th of the area or normals that
/// differ by much: about `count` patches on a smooth surface, more where it has edges, at most one
/// a sample. The same for any number of threads.
SurfaceClusters cluster_surface(const SampledSurface& samples, std::size_t count);

}  // namespace tallow
