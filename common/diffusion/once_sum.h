// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/vec.h"
#include "common/diffusion/leaving_radiance.h"
#include "common/nbody/sum_tree.h"

namespace tallow {

/// Sources under a tree that send light to the surface after one scattering. Lengths in units of
/// the tree.
struct OnceCloud {
    static constexpr int kHeights = 64;
    static constexpr int kDiscPoints = 16;
    /// Sources farther away than so many radii of a cell act as points.
    static constexpr float kFarFromDisc = 4;

    const SumTree* sources;
    std::vector<double> part_before;     // [source] sum of the parts before it; empty without any
    float mean_free_path, eta;           // eta: inside over outside
    float cell_radius;                   // of the disc that a source near the place is
    std::array<Vec2, kDiscPoints> disc;  // places of its light
    /// What a disc of the weight 1 does to a place above its middle, by its height in steps of
    /// cell_radius * kFarFromDisc / kHeights.
    std::array<float, kHeights + 2> above_disc;

    float far() const { return kFarFromDisc * cell_radius; }
    float above_middle(float height) const {
        const float step = height / far() * kHeights;
        const auto i = std::min(std::size_t(step), std::size_t(kHeights));
        return above_disc[i] + (step - float(i)) * (above_disc[i + 1] - above_disc[i]);
    }
    /// Of the weight of `count` sources.
    float part_of(std::uint32_t first, std::uint32_t count) const {
        return part_before.empty() ? 0 : float(part_before[first + count] - part_before[first]);
    }
};

/// Where light leaves, in units of the tree.
struct OncePlace {
    Vec3 position, normal;
    LeavingRadiance reach;  // see LeavingPlace
};

/// Sources of light on its way to one place, side by side for SIMD: room for what is summed, to be
/// used again.
struct OnceSources {
    static constexpr std::size_t kWidth = 16;  // floats in the widest SIMD register there is

    std::vector<float> x, y, z;  // from the source to the place
    std::vector<float> weight, part;
    std::size_t count = 0;

    /// For so many more, a register beyond which may be written over.
    void make_room(std::size_t more) {
        const std::size_t needed = count + more + kWidth;
        if (x.size() >= needed) return;
        for (std::vector<float>* column : {&x, &y, &z, &weight, &part}) column->resize(2 * needed);
    }
    void add(Vec3 way, float w, float part_of_w) {
        x[count] = way.x, y[count] = way.y, z[count] = way.z;
        weight[count] = w, part[count] = part_of_w;
        ++count;
    }
    /// Fills the last register with sources of no weight.
    void close() {
        make_room(kWidth);
        while (count % kWidth != 0) add(Vec3(1), 0, 0);
    }
};

/// The sum with the weights, and with those of a part of the light.
struct OnceSums {
    float all, part;
};

/// One instruction set's version of
///
///     sum of w e^(-d / mean_free_path) mu T(mu) / d^2
///
/// mu is the cosine of the way with the normal, T Fresnel's transmittance from inside.
using OnceSum = OnceSums (*)(const OnceCloud& cloud, const OncePlace& place, OnceSources& room);

/// The version for this machine's best instruction set.
OnceSum once_sum();

}  // namespace tallow
