// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/cluster_field.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tallow {
namespace {

// Standard deviation of the Gaussian in cluster sizes, and where it is cut off.
constexpr float kWidth = 0.7f, kReach = 2.1f;

constexpr int kMostCells = 128;  // along an axis

}  // namespace

ClusterRatio::ClusterRatio(const SurfaceClusters& clusters, std::vector<Rgb> B, std::vector<Rgb> H,
                           Rgb strength)
    : strength_(strength) {
    const std::size_t n = clusters.count();
    if (n == 0) return;
    Vec3 high = low_ = clusters.position[0];
    for (const Vec3& x : clusters.position) low_ = glm::min(low_, x), high = glm::max(high, x);
    size_ = float(clusters.size);
    const float reach = kReach * size_;
    for (int axis = 0; axis < 3; ++axis)
        cells_[axis] = std::clamp(int((high[axis] - low_[axis]) / reach) + 1, 1, kMostCells);
    std::vector<std::size_t> cell(n);
    first_.assign(std::size_t(cells_[0]) * std::size_t(cells_[1]) * std::size_t(cells_[2]) + 1, 0);
    for (std::size_t i = 0; i < n; ++i) ++first_[(cell[i] = cell_of(clusters.position[i])) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    items_.resize(n);
    for (std::size_t i = 0; i < n; ++i)
        items_[next[cell[i]]++] = {clusters.position[i], clusters.normal[i], clusters.area[i], B[i],
                                   H[i]};
}

int ClusterRatio::index(float x, int axis) const {
    const float reach = kReach * size_;
    return std::clamp(int(std::floor((x - low_[axis]) / reach)), 0, cells_[axis] - 1);
}

std::size_t ClusterRatio::cell_of(Vec3 p) const {
    return (std::size_t(index(p.z, 2)) * std::size_t(cells_[1]) + std::size_t(index(p.y, 1))) *
               std::size_t(cells_[0]) +
           std::size_t(index(p.x, 0));
}

Rgb ClusterRatio::at(Vec3 position, Vec3 n) const {
    if (items_.empty()) return Rgb(1);
    const float reach = kReach * size_, sigma = kWidth * size_;
    const Vec3 low = position - Vec3(reach), high = position + Vec3(reach);
    Rgb B, H;
    for (int z = index(low.z, 2); z <= index(high.z, 2); ++z)
        for (int y = index(low.y, 1); y <= index(high.y, 1); ++y) {
            const std::size_t row =
                (std::size_t(z) * std::size_t(cells_[1]) + std::size_t(y)) * std::size_t(cells_[0]);
            const std::size_t end = row + std::size_t(index(high.x, 0)) + 1;
            for (std::uint32_t k = first_[row + std::size_t(index(low.x, 0))]; k < first_[end];
                 ++k) {
                const Item& item = items_[k];
                const Vec3 d = item.position - position;
                const float d2 = glm::dot(d, d);
                const float facing = glm::dot(n, item.normal);
                if (d2 >= reach * reach || facing <= 0) continue;
                // Falls to 0 at the reach, so that nothing jumps there.
                const float edge = 1 - d2 / (reach * reach);
                const float w =
                    item.area * std::exp(-d2 / (2 * sigma * sigma)) * facing * facing * edge * edge;
                B += w * item.B, H += w * item.H;
            }
        }
    Rgb ratio(1);
    for (int c = 0; c < 3; ++c)
        if (H[c] > 0) ratio[c] += strength_[c] * (std::clamp(B[c] / H[c], kLeast, kMost) - 1);
    return ratio;
}

}  // namespace tallow
