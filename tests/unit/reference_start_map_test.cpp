// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "experiments/reference/start_map.h"

namespace tallow::reference {
namespace {

StartMap uneven_map() {
    StartMap::Cells worth{};
    for (std::size_t i = 0; i < worth.size(); ++i) worth[i] = i % 3 == 0 ? 0.0 : double(i % 32);
    return StartMap(worth);
}

// Averages of f / density over drawn points are those of f over even ones.
TEST(ReferenceStartMap, WeightsMakeUpForTheDensity) {
    const StartMap map = uneven_map();
    const Sobol2d points(5);
    constexpr std::uint32_t kPoints = 1 << 16;
    double ones = 0, x = 0, y2 = 0;
    for (std::uint32_t i = 0; i < kPoints; ++i) {
        const auto [u, density] = map.draw(points(i));
        ASSERT_GT(density, 0.05f);
        ASSERT_LT(std::max(u.x, u.y), 1.0f);
        ones += 1 / double(density), x += double(u.x) / double(density);
        y2 += double(u.y * u.y) / double(density);
    }
    EXPECT_NEAR(ones / kPoints, 1, 2e-3);  // measured 1e-4
    EXPECT_NEAR(x / kPoints, 1.0 / 2, 2e-3);
    EXPECT_NEAR(y2 / kPoints, 1.0 / 3, 2e-3);
}

TEST(ReferenceStartMap, DensityIsThatOfItsCell) {
    const StartMap map = uneven_map();
    const Sobol2d points(6);
    std::array<float, std::size_t(StartMap::kSide) * StartMap::kSide> seen{};
    for (std::uint32_t i = 0; i < 1 << 14; ++i) {
        const auto [u, density] = map.draw(points(i));
        float& of_cell = seen[StartMap::cell(u)];
        EXPECT_TRUE(of_cell == 0 || of_cell == density);
        of_cell = density;
    }
}

TEST(ReferenceStartMap, IsEvenWithoutKnowledge) {
    for (const StartMap& map : {StartMap(), StartMap(StartMap::Cells{})}) {
        const auto [u, density] = map.draw({0.25f, 0.75f});
        EXPECT_NEAR(u.x, 0.25f, 1e-6f);
        EXPECT_NEAR(u.y, 0.75f, 1e-6f);
        EXPECT_NEAR(density, 1, 1e-6f);
    }
}

}  // namespace
}  // namespace tallow::reference
