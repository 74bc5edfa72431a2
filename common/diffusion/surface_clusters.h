// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/diffusion/patch_tree.h"

namespace tallow {

/// A surface cut into patches of nearly equal area: neighbours that also face alike, so that the
/// two sides of a thin sheet and of a sharp edge lie in different patches.
struct SurfaceClusters {
    std::vector<std::uint32_t> patch;    // [cluster] in the tree
    std::vector<std::uint32_t> nearest;  // [cluster] the sample nearest to the centroid
    std::vector<Vec3> position;          // [cluster] mm, of that sample
    std::vector<Vec3> normal;            // [cluster] unit, of that sample
    std::vector<float> area;             // [cluster] mm^2
    double size = 0;                     // mm, root of the mean area

    std::size_t count() const { return area.size(); }
};

/// Area at which halving stops so that about `count` patches are left, mm^2.
double largest_cluster_area(double area, std::size_t count);

/// Mean variance of the normals on the clusters, by area: how much of the surface's shape they do
/// not resolve. On a sphere of radius R a disc of radius r has r^2 / (2 R^2).
double normal_variance(const PatchTree& tree, const SurfaceClusters& clusters);

/// The largest patches of the tree without edges of at most `largest_area` [mm^2], in the order of
/// their samples; more than the area would need where the surface has edges, at most one a sample.
/// `largest_area` is at least that of the tree. Patches with edges count, too, whose normals have
/// at most `largest_variance`: 1/2 for two faces at right angles, 1 for two sides of a sheet.
SurfaceClusters cut_clusters(const SampledSurface& samples, const PatchTree& tree,
                             double largest_area, double largest_variance = 0);

}  // namespace tallow
