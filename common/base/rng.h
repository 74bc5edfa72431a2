// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "common/base/vec.h"

namespace tallow {

/// Mixes 64 bits so that every input bit flips half of the output bits.
/// Source: the finalizer of SplitMix64 (Steele, Lea, Flood 2014), with Stafford's variant 13.
constexpr std::uint64_t mix_bits(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

/// Random bits that are a function of where they are used, never of who ran before: the same for
/// any number of threads. `stream` tells apart the uses of one index.
constexpr std::uint32_t random_bits(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
    const std::uint64_t key = mix_bits(seed + 0x9e3779b97f4a7c15ull * (stream + 1));
    return static_cast<std::uint32_t>(mix_bits(key ^ (index * 0xd1342543de82ef95ull)) >> 32);
}

/// Uniform in [0, 1): 24 bits, so that it is never rounded up to 1.
constexpr float to_unit_float(std::uint32_t bits) {
    return static_cast<float>(bits >> 8) * 0x1p-24f;
}

/// A two-dimensional low-discrepancy sequence, scrambled by `scramble`: any 2^k consecutive aligned
/// points are one in each elementary interval of area 2^-k.
///
/// Source: the (0,2)-sequence of Sobol's first two dimensions; hash-based Owen scrambling after
/// Burley 2020, "Practical Hash-based Owen Scrambling".
class Sobol2d {
public:
    explicit Sobol2d(std::uint64_t scramble);
    Vec2 operator()(std::uint32_t index) const;  ///< in [0, 1)^2

private:
    std::uint32_t seed_x_, seed_y_;
};

inline Vec2 sobol_2d(std::uint32_t index, std::uint64_t scramble) {
    return Sobol2d(scramble)(index);
}

/// A permutation of indices that takes aligned blocks of 2^k to aligned blocks: a sequence in this
/// order is as good as before, and can stand beside the one in the old order without correlation.
/// Source: Burley 2020, as above, section 5.
std::uint32_t shuffled_index(std::uint32_t index, std::uint64_t seed);

/// Coordinate `index` of the same sequence's third dimension: with Sobol2d, whatever their
/// scrambles, any 2^k consecutive aligned points are two in each elementary box of volume 2^(1-k),
/// and each coordinate alone is one in each interval of 2^-k.
///
/// Source: Sobol's third dimension, polynomial x^2 + x + 1, first direction numbers 1 and 3 (Joe,
/// Kuo 2008, "Constructing Sobol sequences with better two-dimensional projections").
float sobol_third(std::uint32_t index, std::uint64_t scramble);

}  // namespace tallow
