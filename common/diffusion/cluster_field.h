// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/base/rgb.h"
#include "common/diffusion/surface_clusters.h"

namespace tallow {

/// The ratio of two fields that are known at the clusters of a surface, between them:
///
///     ratio(x, n) = sum of w_j B_j / sum of w_j H_j
///     w_j = a_j e^(-|x - x_j|^2 / (2 h^2)) max(0, n . n_j)^2
///
/// with h near the clusters' size. Clamped to [kLeast, kMost], where the body's field is lost in
/// the rounding of its largest values.
class ClusterRatio {
public:
    static constexpr float kLeast = 0.02f, kMost = 50;

    /// B[cluster] and H[cluster] >= 0. `strength` is the share of the ratio's departure from 1 that
    /// counts.
    ClusterRatio(const SurfaceClusters& clusters, std::vector<Rgb> B, std::vector<Rgb> H,
                 Rgb strength = Rgb(1));

    /// At a point of the surface [mm] with its unit normal; 1 where nothing is known.
    Rgb at(Vec3 position, Vec3 n) const;

private:
    struct Item {
        Vec3 position, normal;
        float area;
        Rgb B, H;
    };
    std::size_t cell_of(Vec3 position) const;
    int index(float x, int axis) const;

    Rgb strength_;
    float size_ = 0;  // of a cluster, mm
    Vec3 low_{0};
    int cells_[3] = {1, 1, 1};
    std::vector<std::uint32_t> first_;  // [cell + 1] into items_
    std::vector<Item> items_;           // cell by cell
};

}  // namespace tallow
