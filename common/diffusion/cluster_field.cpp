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

float cosine_inside(float eta, float cos_o) {
    return std::sqrt(1 - (1 - cos_o * cos_o) / (eta * eta));
}

// Light that scatters twice in a half-space without an interface, by its cosines, times a constant.
float second_order(float mu_0, float mu) {
    const auto f = [](float x) { return x * std::log1p(1 / std::max(x, 1e-6f)); };
    return (f(mu_0) + f(mu)) / std::max(mu_0 + mu, 1e-6f);
}

}  // namespace

ClusterNeighbours::ClusterNeighbours(const SurfaceClusters& clusters) {
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
    for (std::uint32_t i = 0; i < n; ++i)
        items_[next[cell[i]]++] = {clusters.position[i], clusters.normal[i], clusters.area[i], i};
}

int ClusterNeighbours::index(float x, int axis) const {
    const float reach = kReach * size_;
    return std::clamp(int(std::floor((x - low_[axis]) / reach)), 0, cells_[axis] - 1);
}

std::size_t ClusterNeighbours::cell_of(Vec3 p) const {
    return (std::size_t(index(p.z, 2)) * std::size_t(cells_[1]) + std::size_t(index(p.y, 1))) *
               std::size_t(cells_[0]) +
           std::size_t(index(p.x, 0));
}

template <class F>
void ClusterNeighbours::visit(Vec3 position, Vec3 n, const F& f) const {
    if (items_.empty()) return;
    const float reach = kReach * size_, sigma = kWidth * size_;
    const Vec3 low = position - Vec3(reach), high = position + Vec3(reach);
    for (int z = index(low.z, 2); z <= index(high.z, 2); ++z)
        for (int y = index(low.y, 1); y <= index(high.y, 1); ++y) {
            const std::size_t row =
                (std::size_t(z) * std::size_t(cells_[1]) + std::size_t(y)) * std::size_t(cells_[0]);
            const std::size_t end = row + std::size_t(index(high.x, 0)) + 1;
            for (std::uint32_t k = first_[row + std::size_t(index(low.x, 0))]; k < first_[end];
                 ++k) {
                const Item& item = items_[k];
                const float d2 = length2(item.position - position);
                const float facing = glm::dot(n, item.normal);
                if (d2 >= reach * reach || facing <= 0) continue;
                // Falls to 0 at the reach, so that nothing jumps there.
                const float edge = 1 - d2 / (reach * reach);
                f(item.cluster,
                  item.area * std::exp(-d2 / (2 * sigma * sigma)) * facing * facing * edge * edge);
            }
        }
}

ClusterRatio::ClusterRatio(const SurfaceClusters& clusters, std::vector<Rgb> B, std::vector<Rgb> H,
                           Rgb strength)
    : neighbours_(clusters), B_(std::move(B)), H_(std::move(H)), strength_(strength) {}

Rgb ClusterRatio::at(Vec3 position, Vec3 n) const {
    Rgb B, H, ratio(1);
    neighbours_.visit(position, n,
                      [&](std::uint32_t i, float w) { B += w * B_[i], H += w * H_[i]; });
    for (int c = 0; c < 3; ++c)
        if (H[c] > 0) ratio[c] += strength_[c] * (std::clamp(B[c] / H[c], kLeast, kMost) - 1);
    return ratio;
}

LeavingField::LeavingField(const SurfaceClusters& clusters, const AtClusters& fields, float eta,
                           bool directional, Rgb strength)
    : neighbours_(clusters),
      items_(clusters.count()),
      strength_(strength),
      eta_(eta),
      directional_(directional),
      mean_cosine_(mean_cosine_of_leaving(eta)) {
    for (std::size_t i = 0; i < items_.size(); ++i) {
        items_[i].rest = fields.rest[i], items_[i].P = fields.P[i];
        items_[i].E = fields.E[i], items_[i].E_mu = fields.E_mu[i];
        for (std::size_t c = 0; c < 3; ++c) {
            items_[i].even[int(c)] = fields.radiance[i][c].even;
            items_[i].slope[c] = fields.radiance[i][c].slope;
        }
    }
}

Rgb LeavingField::factor(Vec3 position, Vec3 n, Vec3 w_o, Rgb P) const {
    const float cos_o = std::clamp(glm::dot(w_o, n), 0.0f, 1.0f);
    const Vec3 w =
        directional_ ? (w_o - cos_o * n) / eta_ + cosine_inside(eta_, cos_o) * n : mean_cosine_ * n;
    float weights = 0;
    Rgb X, rest, P_c, E, E_mu, factor(1);
    neighbours_.visit(position, n, [&](std::uint32_t i, float weight) {
        const Item& item = items_[i];
        for (int c = 0; c < 3; ++c)
            X[c] += weight * (item.even[c] + glm::dot(item.slope[std::size_t(c)], w));
        rest += weight * item.rest, P_c += weight * item.P;
        E += weight * item.E, E_mu += weight * item.E_mu;
        weights += weight;
    });
    const float mu = directional_ ? cosine_inside(eta_, cos_o) : mean_cosine_;
    for (int c = 0; c < 3; ++c) {
        if (P_c[c] <= 0) continue;
        const float q = E[c] > 0 ? second_order(std::min(1.0f, E_mu[c] / E[c]), mu) /
                                       second_order(1, mean_cosine_)
                                 : 1;
        const float M_c = std::max(0.0f, X[c]) + q * rest[c];
        // More than the profile has is not multiplied where the profile has more than around.
        const float as_much = M_c > P_c[c] && weights * P[c] > P_c[c]
                                  ? 1 + (M_c - P_c[c]) / (weights * P[c])
                                  : M_c / P_c[c];
        factor[c] +=
            strength_[c] * (std::clamp(as_much, ClusterRatio::kLeast, ClusterRatio::kMost) - 1);
    }
    return factor;
}

}  // namespace tallow
