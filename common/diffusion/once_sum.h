// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/base/vec.h"

namespace tallow {

/// Sources of light on its way to one place, side by side for SIMD.
struct OnceSources {
    static constexpr std::size_t kWidth = 16;  // floats in the widest SIMD register there is

    std::vector<float> x, y, z;  // from the source to the place
    std::vector<float> weight, part;

    void clear() { x.clear(), y.clear(), z.clear(), weight.clear(), part.clear(); }
    void add(Vec3 way, float w, float part_of_w) {
        x.push_back(way.x), y.push_back(way.y), z.push_back(way.z);
        weight.push_back(w), part.push_back(part_of_w);
    }
    /// Fills the last register with sources of no weight.
    void close() {
        while (x.size() % kWidth != 0) add(Vec3(1), 0, 0);
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
/// mu is the cosine of the way with the normal, T Fresnel's transmittance from inside, of the
/// relative index eta.
using OnceSum = OnceSums (*)(const OnceSources& sources, Vec3 normal, float mean_free_path,
                             float eta);

/// The version for this machine's best instruction set.
OnceSum once_sum();

}  // namespace tallow
