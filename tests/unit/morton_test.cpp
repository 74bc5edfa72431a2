// SPDX-License-Identifier: Apache-2.0
#include "common/cloud/morton.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <numeric>

#include "common/base/parallel.h"
#include "common/base/rng.h"

namespace tallow {
namespace {

using Keys = std::vector<std::uint64_t>;

TEST(MortonCodes, TheHighestBitsPickTheOctant) {
    const std::vector<Vec3> corners = {{0, 0, 0}, {0, 0, 2}, {0, 2, 0}, {0, 2, 2},
                                       {2, 0, 0}, {2, 0, 2}, {2, 2, 0}, {2, 2, 2}};
    EXPECT_EQ(morton_codes(corners, 1), (Keys{0, 1, 2, 3, 4, 5, 6, 7}));
    const Keys codes = morton_codes(corners);
    EXPECT_EQ(codes.front(), 0u);
    EXPECT_EQ(codes.back(), (std::uint64_t{1} << 63) - 1);
    for (std::size_t i = 0; i < codes.size(); ++i) EXPECT_EQ(codes[i] >> 60, i);
}

TEST(MortonCodes, ShortCodesAreTheLeadingBitsOfLongOnes) {
    std::vector<Vec3> points;
    for (std::uint64_t i = 0; i < 5000; ++i)
        points.push_back({to_unit_float(random_bits(1, 0, i)), to_unit_float(random_bits(1, 1, i)),
                          7 * to_unit_float(random_bits(1, 2, i)) - 3});
    const Keys codes = morton_codes(points), codes10 = morton_codes(points, 10);
    for (std::size_t i = 0; i < points.size(); ++i) ASSERT_EQ(codes10[i], codes[i] >> 33);
}

TEST(MortonCodes, OfNoPointsAndOfOnePlace) {
    EXPECT_TRUE(morton_codes({}).empty());
    const std::vector<Vec3> same(3, Vec3(1, -2, 3));
    EXPECT_EQ(morton_codes(same), Keys(3, 0));
}

std::vector<std::uint32_t> stable_order(const Keys& keys) {
    std::vector<std::uint32_t> order(keys.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return keys[i]; });
    return order;
}

template <class Key>
Keys make_keys(std::size_t n, const Key& key) {
    Keys keys(n);
    for (std::size_t i = 0; i < n; ++i) keys[i] = key(std::uint64_t(i));
    return keys;
}

// Sizes on both sides of where the sort changes its ways: comparison, one chunk, several chunks.
constexpr std::size_t kSizes[] = {0, 1, 2, 3, 500, 600, 60000, 200001};

TEST(SortedOrder, IsThatOfAStableSort) {
    for (const std::size_t n : kSizes) {
        SCOPED_TRACE(n);
        for (const Keys& keys : {
                 make_keys(n, [](std::uint64_t i) { return mix_bits(i); }),
                 make_keys(n, [](std::uint64_t i) { return mix_bits(i) >> 34; }),
                 make_keys(n, [](std::uint64_t i) { return mix_bits(i) & 0x8000000000000003u; }),
                 make_keys(n, [](std::uint64_t i) { return i; }),
                 make_keys(n, [](std::uint64_t i) { return ~i; }),
                 make_keys(n, [](std::uint64_t) { return std::uint64_t{5}; }),
             })
            ASSERT_EQ(sorted_order(keys), stable_order(keys));
    }
}

// A far point and a cluster: the leading bits say nothing about most keys.
TEST(SortedOrder, OfKeysThatDifferInTheirLowestBits) {
    for (const std::size_t n : kSizes) {
        SCOPED_TRACE(n);
        Keys keys = make_keys(n, [](std::uint64_t i) { return mix_bits(i) >> 48; });
        if (n > 0) keys[n / 2] |= std::uint64_t{1} << 63;
        ASSERT_EQ(sorted_order(keys), stable_order(keys));
    }
}

// Runs of all lengths that agree in their leading bits, some longer than what one task takes.
TEST(SortedOrder, OfRunsOfAllLengths) {
    const Keys keys = make_keys(300000, [](std::uint64_t i) {
        const std::uint64_t run = std::bit_width(i);  // half of the keys are in the last
        return run << 58 | (mix_bits(i) & 0xfff);
    });
    ASSERT_EQ(sorted_order(keys), stable_order(keys));
}

TEST(SortedOrder, IsTheSameForAnyNumberOfThreads) {
    const Keys keys = make_keys(200001, [](std::uint64_t i) { return mix_bits(i) & ~0xffffull; });
    const std::vector<std::uint32_t> expected = stable_order(keys);
    for (int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        EXPECT_EQ(sorted_order(keys), expected) << threads << " threads";
    }
}

}  // namespace
}  // namespace tallow
