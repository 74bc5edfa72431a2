// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "common/base/rng.h"

namespace tallow::reference {

/// Uniform numbers of one walk, a function of the batch's seed and the walk's number only.
/// Source   xoroshiro128+ (Blackman, Vigna 2018), seeded through mix_bits().
class WalkRandom {
public:
    WalkRandom(std::uint64_t seed, std::uint64_t walk)
        : a_(mix_bits(mix_bits(seed) + 2 * walk)), b_(mix_bits(a_ ^ 0x9e3779b97f4a7c15ull)) {
        if ((a_ | b_) == 0) b_ = 1;
    }

    /// In (0, 1): a float of 32 random bits, so that -log() of it reaches 22.
    float next() {
        const std::uint64_t sum = a_ + b_;
        const std::uint64_t mixed = a_ ^ b_;
        a_ = std::rotl(a_, 24) ^ mixed ^ (mixed << 16);
        b_ = std::rotl(mixed, 37);
        // 1 - 2^-25 is rounded down to the largest float below 1, never up to it.
        const float u = (float(sum >> 40) + 0.5f) * 0x1p-24f;
        if (u > 0x1p-8f) [[likely]]
            return u < 1 ? u : 0x1.fffffep-1f;
        return (float(std::uint32_t(sum >> 32)) + 0.5f) * 0x1p-32f;
    }

    /// Exponentially distributed with mean 1: an optical free path.
    float exponential() { return -std::log(next()); }

private:
    std::uint64_t a_, b_;
};

}  // namespace tallow::reference
