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

// Second Sobol dimension: its generator matrix is Pascal's triangle modulo 2.
constexpr std::uint32_t sobol_second(std::uint32_t index) {
    std::uint32_t result = 0;
    for (std::uint32_t v = 1u << 31; index != 0; index >>= 1, v ^= v >> 1)
        if (index & 1u) result ^= v;
    return result;
}

// Each output bit is flipped depending on the bits above it only: a nested uniform scramble.
// The multiplications act from low to high bits, hence the reversals. Constants: [Burley 2020].
constexpr std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed) {
    x = reverse_bits(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverse_bits(x);
}

}  // namespace

Vec2 sobol_2d(std::uint32_t index, std::uint64_t scramble) {
    const auto seed_x = static_cast<std::uint32_t>(mix_bits(scramble) >> 32);
    const auto seed_y =
        static_cast<std::uint32_t>(mix_bits(scramble ^ 0x6a09e667f3bcc909ull) >> 32);
    return {to_unit_float(owen_scramble(reverse_bits(index), seed_x)),
            to_unit_float(owen_scramble(sobol_second(index), seed_y))};
}

}  // namespace tallow
