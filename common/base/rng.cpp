// SPDX-License-Identifier: Apache-2.0
#include "common/base/rng.h"

namespace tallow {
namespace {

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
    x = (x << 16) | (x >> 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

// Second Sobol dimension, its bits reversed: Pascal's triangle modulo 2 times the index. That
// matrix is the fivefold Kronecker product of [1 1; 0 1], hence one step a factor.
constexpr std::uint32_t reversed_sobol_second(std::uint32_t x) {
    x ^= (x & 0xaaaaaaaau) >> 1;
    x ^= (x & 0xccccccccu) >> 2;
    x ^= (x & 0xf0f0f0f0u) >> 4;
    x ^= (x & 0xff00ff00u) >> 8;
    return x ^ x >> 16;
}

// Third Sobol dimension, its bits reversed. Direction numbers v_i = v_(i-1) ^ v_(i-2) ^ v_(i-2)
// / 4.
constexpr std::uint32_t reversed_sobol_third(std::uint32_t index) {
    std::uint32_t result = 0;
    for (std::uint32_t v = 1, next = 3; index != 0; index >>= 1) {
        if (index & 1u) result ^= v;
        const std::uint32_t after = next ^ v ^ (v << 2);
        v = next, next = after;
    }
    return result;
}

// Each output bit is flipped depending on the bits above it only: a nested uniform scramble. The
// multiplications act from low to high bits, so that the input comes with its bits reversed.
// Constants: [Burley 2020].
constexpr std::uint32_t owen_scramble_reversed(std::uint32_t x, std::uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverse_bits(x);
}

}  // namespace

Sobol2d::Sobol2d(std::uint64_t scramble)
    : seed_x_(static_cast<std::uint32_t>(mix_bits(scramble) >> 32)),
      seed_y_(static_cast<std::uint32_t>(mix_bits(scramble ^ 0x6a09e667f3bcc909ull) >> 32)) {}

Vec2 Sobol2d::operator()(std::uint32_t index) const {
    return {to_unit_float(owen_scramble_reversed(index, seed_x_)),
            to_unit_float(owen_scramble_reversed(reversed_sobol_second(index), seed_y_))};
}

std::uint32_t shuffled_index(std::uint32_t index, std::uint64_t seed) {
    return owen_scramble_reversed(reverse_bits(index), static_cast<std::uint32_t>(mix_bits(seed)));
}

float sobol_third(std::uint32_t index, std::uint64_t scramble) {
    const auto seed = static_cast<std::uint32_t>(mix_bits(scramble ^ 0xbb67ae8584caa73bull) >> 32);
    return to_unit_float(owen_scramble_reversed(reversed_sobol_third(index), seed));
}

}  // namespace tallow
