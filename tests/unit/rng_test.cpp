// SPDX-License-Identifier: Apache-2.0
#include "common/base/rng.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace tallow
