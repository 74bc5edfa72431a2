// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "render/single_scatter.h"

namespace tallow {

/// Places on a body's surface where light enters, and the area that each stands for.
struct EntryPoints {
    std::span<const Vec3> positions;  // [point] mm
    std::span<const Vec3> normals;    // [point] unit, outward
    std::span<const float> areas;     // [point] mm^2
};

/// Fluence inside a body of light that has been reflected by its surface from inside, once or more,
/// and has not been scattered: what refracted paths of light do not hold. It matters in parts that
/// light crosses: ears, fingers, edges of leaves.
///
/// From each entry point rays are sent to every light, refracted into the body, and followed over
/// reflections inside; what is lost on the way and what leaves is taken off. The body is divided
/// into cells, and a cell's fluence is the power of the rays times their length in it, over the
/// volume of the cell that lies inside. That is measured in the same way, by rays that enter with
/// the density cos / pi and cover the body evenly:
///
///     phi = sum Phi e^(-sigma_t s) ds / V,   V = sum A ds / 4
///
/// Units    W/mm^2.
/// Error    blurred over two cells of half a mean free path each, and noise of some 10 to 20 % of
///          itself; it is 3 to 7 % of what is scattered once on the thin figures of
///          experiments/cases.
/// Source   track-length estimators are from neutron transport: Spanier, Gelbard 1969.
class InnerLight {
public:
    /// Deterministic for any number of threads. `share()` is measured with few rays first, and
    /// below `least_share` nothing more is done.
    InnerLight(const ScatteringBody& body, const EntryPoints& entries, double least_share);

    /// Of the power that is scattered once, the part that was reflected inside before.
    double share() const { return share_; }
    bool empty() const { return cells_.empty(); }

    /// Interpolated between cells; 0 where nothing is known.
    Rgb fluence(Vec3 x) const;

private:
    struct Cell {
        Rgb flux_length;   // W mm
        float volume = 0;  // mm^3
    };

    void lay_cells(const ScatteringBody& body);
    std::size_t index(int x, int y, int z) const {
        return (std::size_t(z) * std::size_t(count_[1]) + std::size_t(y)) * std::size_t(count_[0]) +
               std::size_t(x);
    }
    Cell* cell_at(Vec3 p);

    Vec3 origin_{0};
    float size_ = 1;  // of a cell, mm
    std::array<int, 3> count_{};
    std::vector<Cell> cells_;
    double share_ = 0;
};

}  // namespace tallow
