// SPDX-License-Identifier: Apache-2.0
#include "common/base/rng.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

namespace tallow {
namespace {

constexpr std::uint64_t kScrambles[] = {0, 1, 0x123456789abcdefull};
constexpr std::uint32_t kStarts[] = {0, 7, 40000};  // of aligned runs of points

// Every 2^k aligned points are one in each interval of 2^-i by 2^(i-k).
TEST(Sobol, TwoDimensionsAreANet) {
    for (const std::uint64_t scramble : kScrambles)
        for (const std::uint32_t start : kStarts)
            for (int k = 0; k <= 8; ++k)
                for (int i = 0; i <= k; ++i) {
                    std::vector<int> hits(1u << k);
                    for (std::uint32_t n = 0; n < 1u << k; ++n) {
                        const Vec2 u = sobol_2d((start << k) + n, scramble);
                        ASSERT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1);
                        const auto column = std::uint32_t(u.x * float(1 << i)),
                                   row = std::uint32_t(u.y * float(1 << (k - i)));
                        ++hits[(column << (k - i)) + row];
                    }
                    for (const int count : hits) ASSERT_EQ(count, 1) << k << ' ' << i;
                }
}

// With the third dimension, under scrambles of its own: two in each box of 2^(1-k), one in each of
// its intervals of 2^-k.
TEST(Sobol, ThirdDimensionKeepsBoxesEven) {
    for (const std::uint64_t scramble : kScrambles)
        for (const std::uint32_t start : kStarts)
            for (int k = 1; k <= 8; ++k)
                for (int i = 0; i <= k - 1; ++i)
                    for (int j = 0; i + j <= k - 1; ++j) {
                        const int rest = k - 1 - i - j;
                        std::vector<int> hits(1u << (k - 1)), third(1u << k);
                        for (std::uint32_t n = 0; n < 1u << k; ++n) {
                            const Vec2 u = sobol_2d((start << k) + n, scramble);
                            const float v = sobol_third((start << k) + n, ~scramble);
                            const auto a = std::uint32_t(u.x * float(1 << i)),
                                       b = std::uint32_t(u.y * float(1 << j)),
                                       c = std::uint32_t(v * float(1 << rest));
                            ++hits[(((a << j) + b) << rest) + c];
                            ++third[std::uint32_t(v * float(1 << k))];
                        }
                        for (const int count : hits) ASSERT_EQ(count, 2) << k << i << j;
                        for (const int count : third) ASSERT_EQ(count, 1) << k;
                    }
}

// The order changes, the blocks do not.
TEST(ShuffledIndex, PermutesAlignedBlocks) {
    for (const std::uint64_t seed : kScrambles)
        for (const std::uint32_t start : kStarts)
            for (int k = 0; k <= 8; ++k) {
                std::vector<int> hits(1u << k);
                const std::uint32_t block = shuffled_index(start << k, seed) >> k;
                for (std::uint32_t n = 0; n < 1u << k; ++n) {
                    const std::uint32_t index = shuffled_index((start << k) + n, seed);
                    ASSERT_EQ(index >> k, block);
                    ++hits[index & ((1u << k) - 1)];
                }
                for (const int count : hits) ASSERT_EQ(count, 1);
            }
}

// Halves of x of a sequence and of its shuffled copy: with one order for both, they would go
// together in every point or in none. 64 seeds of 64 points: the mean share of points that agree is
// 1/2 with a standard deviation of at most 0.07; half of the seeds must lie within 0.1 of it.
TEST(ShuffledIndex, BreaksTheCorrelation) {
    int even = 0;
    for (std::uint64_t seed = 0; seed < 64; ++seed) {
        int together = 0;
        for (std::uint32_t n = 0; n < 64; ++n) {
            const float x = sobol_2d(n, mix_bits(seed)).x;
            const float shuffled = sobol_2d(shuffled_index(n, ~seed), ~seed).x;
            together += (x < 0.5f) == (shuffled < 0.5f);
        }
        even += std::abs(together - 32) <= 6;
    }
    EXPECT_GE(even, 32);
}

}  // namespace
}  // namespace tallow
