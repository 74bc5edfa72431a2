// SPDX-License-Identifier: Apache-2.0
#include "experiments/reference/start_map.h"

#include <algorithm>
#include <cmath>

namespace tallow::reference {
namespace {

constexpr int kSide = StartMap::kSide;

/// Mean over a cell and its neighbours.
StartMap::Cells smooth(const StartMap::Cells& of) {
    StartMap::Cells result{};
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            double sum = 0, count = 0;
            for (int j = std::max(0, y - 1); j <= std::min(kSide - 1, y + 1); ++j)
                for (int i = std::max(0, x - 1); i <= std::min(kSide - 1, x + 1); ++i)
                    sum += of[std::size_t(j * kSide + i)], ++count;
            result[std::size_t(y * kSide + x)] = sum / count;
        }
    return result;
}

/// Index i with up_to[i] <= u < up_to[i + 1].
template <std::size_t N>
std::size_t find(const std::array<double, N>& up_to, double u) {
    const auto above = std::upper_bound(up_to.begin() + 1, up_to.end() - 1, u);
    return std::size_t(above - up_to.begin()) - 1;
}

}  // namespace

StartMap::StartMap()
    : StartMap([] {
          Cells even;
          even.fill(1);
          return even;
      }()) {}

StartMap::StartMap(const Cells& worth) : density_(smooth(worth)) {
    constexpr double kLeast = 0.1;
    double mean = 0;
    for (double w : density_) mean += w / double(density_.size());
    if (!(mean > 0)) density_.fill(1), mean = 1;
    for (double& d : density_) d = kLeast + (1 - kLeast) * d / mean;
    rows_[0] = 0;
    for (std::size_t y = 0; y < kSide; ++y) {
        columns_[y][0] = 0;
        for (std::size_t x = 0; x < kSide; ++x)
            columns_[y][x + 1] = columns_[y][x] + density_[y * kSide + x];
        const double row = columns_[y][kSide];
        rows_[y + 1] = rows_[y] + row;
        for (double& up_to : columns_[y]) up_to /= row;
    }
    const double all = rows_[kSide];
    for (double& up_to : rows_) up_to /= all;
    for (double& d : density_) d *= double(density_.size()) / all;
}

StartMap::Drawn StartMap::draw(Vec2 u) const {
    constexpr double kBelowOne = 1 - 0x1p-25;
    const auto warp = [&](const auto& up_to, double at, std::size_t& cell) {
        cell = find(up_to, at);
        const double within = (at - up_to[cell]) / (up_to[cell + 1] - up_to[cell]);
        return (double(cell) + std::clamp(within, 0.0, kBelowOne)) / kSide;
    };
    std::size_t row = 0, column = 0;
    const double y = warp(rows_, double(u.y), row);
    const double x = warp(columns_[row], double(u.x), column);
    // Rounding to float must not reach 1, nor the next cell, whose density is another.
    const auto low = [](double v, std::size_t cell) {
        const float end = float(cell + 1) / kSide;
        return std::min(float(v), std::nextafter(end, 0.0f));
    };
    return {{low(x, column), low(y, row)}, float(density_[row * kSide + column])};
}

}  // namespace tallow::reference
