// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/surface_clusters.h"

#include <algorithm>
#include <cmath>

#include "common/base/parallel.h"

namespace tallow {
namespace {

// Halving leaves patches of half to all of the area at which it stops: their mean.
constexpr double kMeanOfHalving = 0.72;

double normal_variance(const SurfacePatch& patch) {
    const double a = double(patch.area);
    return std::max(0.0, 1 - double(length2(patch.vector_area)) / (a * a));
}

void add_patches(const PatchTree& tree, std::uint32_t i, double largest_area,
                 double largest_variance, const std::vector<char>& is_fine,
                 std::vector<std::uint32_t>& result) {
    const SurfacePatch& patch = tree.patches[i];
    const bool acts_as_one = !patch.edge || normal_variance(patch) <= largest_variance;
    if (is_fine[i] || (acts_as_one && double(patch.area) <= largest_area)) {
        result.push_back(i);
        return;
    }
    add_patches(tree, patch.child, largest_area, largest_variance, is_fine, result);
    add_patches(tree, patch.child + 1, largest_area, largest_variance, is_fine, result);
}

std::uint32_t nearest_to_centroid(const SampledSurface& samples, const PatchTree& tree,
                                  const SurfacePatch& patch) {
    const auto distance2 = [&](std::uint32_t s) {
        return length2(samples.position[s] - patch.centroid);
    };
    const auto members = tree.samples(patch);
    return *std::ranges::min_element(members, {},
                                     [&](std::uint32_t s) { return std::pair(distance2(s), s); });
}

}  // namespace

double largest_cluster_area(double area, std::size_t count) {
    return area / (kMeanOfHalving * double(count));
}

double normal_variance(const PatchTree& tree, const SurfaceClusters& clusters) {
    double sum = 0, area = 0;
    for (const std::uint32_t i : clusters.patch) {
        const SurfacePatch& patch = tree.patches[i];
        sum += double(patch.area) * normal_variance(patch);
        area += double(patch.area);
    }
    return area > 0 ? sum / area : 0;
}

SurfaceClusters cut_clusters(const SampledSurface& samples, const PatchTree& tree,
                             double largest_area, double largest_variance) {
    SurfaceClusters clusters;
    if (tree.patches.empty()) return clusters;
    std::vector<char> is_fine(tree.patches.size());
    for (const std::uint32_t i : tree.fine) is_fine[i] = 1;
    add_patches(tree, 0, largest_area, largest_variance, is_fine, clusters.patch);
    const std::size_t n = clusters.patch.size();
    clusters.nearest.resize(n), clusters.area.resize(n);
    clusters.position.resize(n), clusters.normal.resize(n);
    parallel_for(n, 16, [&](std::size_t i) {
        const SurfacePatch& patch = tree.patches[clusters.patch[i]];
        const std::uint32_t nearest = nearest_to_centroid(samples, tree, patch);
        clusters.nearest[i] = nearest;
        clusters.position[i] = samples.position[nearest];
        clusters.normal[i] = samples.normal[nearest];
        clusters.area[i] = patch.area;
    });
    clusters.size = std::sqrt(tree.area / double(n));
    return clusters;
}

}  // namespace tallow
