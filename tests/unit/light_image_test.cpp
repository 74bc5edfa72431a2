// SPDX-License-Identifier: Apache-2.0
// The table that draws points of a picture: its density is the one it claims, and its points keep
// the order of what they are made from.
#include "common/scene/light_image.h"

#include <gtest/gtest.h>

#include "tests/support/light_estimates.h"

namespace tallow {
namespace {

using Layout = LightImage::Layout;

RgbImage noise(int width, int height, std::uint64_t seed) {
    RgbImage image{width, height, {}};
    for (int i = 0; i < width * height; ++i) {
        const float v = test::random_point(seed, i).x;
        image.pixels.push_back(Rgb(v * v, v * v * v, 0.5f * v));
    }
    return image;
}

std::vector<LightImage> pictures() {
    std::vector<LightImage> all;
    for (const Layout layout : {Layout::flat, Layout::directions}) {
        all.emplace_back(noise(5, 4, 1), layout);
        all.emplace_back(noise(1, 6, 2), layout);
        all.emplace_back(noise(6, 1, 3), layout);
        RgbImage sun{16, 8, std::vector<Rgb>(128, Rgb(0.5f))};
        sun.pixels[0] = Rgb(1000);  // at the corner: beside the seam and the pole
        all.emplace_back(sun, layout);
    }
    return all;
}

/// Mean of f over a grid in the unit square.
template <class F>
double mean_over_square(int steps, F&& f) {
    double sum = 0;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j)
            sum += f(Vec2((float(i) + 0.5f) / float(steps), (float(j) + 0.5f) / float(steps)));
    return sum / steps / steps;
}

TEST(LightImage, DensityIntegratesToOne) {
    for (const LightImage& image : pictures()) {
        if (image.share() == 0) continue;
        // Measured 5e-8: the midpoint rule is exact, as the grid divides the cells.
        EXPECT_NEAR(mean_over_square(960, [&](Vec2 uv) { return image.at(uv).density; }), 1, 1e-6);
    }
}

// Points fall into each cell of an 8 x 8 grid as often as the density says.
TEST(LightImage, DrawsWithItsDensity) {
    constexpr int kGrid = 8, kCount = 1 << 18;
    for (const LightImage& image : pictures()) {
        if (image.share() == 0) continue;
        std::vector<double> drawn(kGrid * kGrid), claimed(kGrid * kGrid);
        const auto cell = [&](Vec2 uv) {
            return std::size_t(std::min(int(uv.y * kGrid), kGrid - 1) * kGrid +
                               std::min(int(uv.x * kGrid), kGrid - 1));
        };
        for (int k = 0; k < kCount; ++k)
            drawn[cell(image.draw(sobol_2d(std::uint32_t(k), 5)))] += 1.0 / kCount;
        mean_over_square(960, [&](Vec2 uv) {
            claimed[cell(uv)] += image.at(uv).density / 960 / 960;
            return 0;
        });
        for (std::size_t i = 0; i < drawn.size(); ++i)
            EXPECT_NEAR(drawn[i], claimed[i], 1e-4) << i;  // measured 3e-5
    }
}

// Growing u.y never moves a point up, growing u.x never to the left: what is stratified stays so.
TEST(LightImage, KeepsTheOrderOfPoints) {
    for (const LightImage& image : pictures()) {
        if (image.share() == 0) continue;
        for (const float fixed : {0.1f, 0.4f, 0.9f}) {
            Vec2 last(0);
            for (int i = 0; i < 400; ++i) {
                const float u = float(i) / 400;
                const Vec2 now(image.draw({u, fixed}).x, image.draw({fixed, u}).y);
                EXPECT_GE(now.x, last.x) << i;
                EXPECT_GE(now.y, last.y) << i;
                last = now;
            }
        }
    }
}

// The part of points in the upper third: independent points would miss it by 0.007.
TEST(LightImage, StratifiedPointsStayStratified) {
    const LightImage image(noise(64, 32, 9), Layout::directions);
    constexpr int kPoints = 4096;
    const double truth =
        mean_over_square(960, [&](Vec2 uv) { return uv.y < 1.0f / 3 ? image.at(uv).density : 0; });
    int drawn = 0;
    for (int k = 0; k < kPoints; ++k)
        drawn += image.draw(sobol_2d(std::uint32_t(k), 1)).y < 1.0f / 3;
    EXPECT_NEAR(double(drawn) / kPoints, truth, 1e-3);  // measured 1.3e-4
}

TEST(LightImage, InterpolatesBetweenPixelCentres) {
    const RgbImage pixels{2, 2, {Rgb(1), Rgb(2), Rgb(3), Rgb(5)}};
    const LightImage flat(pixels, Layout::flat), around(pixels, Layout::directions);
    EXPECT_EQ(flat.at({0.25f, 0.25f}).color, Rgb(1));
    EXPECT_EQ(flat.at({0.75f, 0.75f}).color, Rgb(5));
    EXPECT_EQ(flat.at({0.5f, 0.5f}).color, Rgb(2.75f));
    EXPECT_EQ(flat.at({0, 0}).color, Rgb(1));
    EXPECT_EQ(flat.at({1, 0.75f}).color, Rgb(5));
    EXPECT_EQ(around.at({0.25f, 0}).color, Rgb(1));
    EXPECT_EQ(around.at({0, 0.25f}).color, Rgb(1.5f)) << "the seam";
    EXPECT_EQ(around.at({1, 0.75f}).color, Rgb(4));
}

TEST(LightImage, ShareIsWhatIsAboveTheMean) {
    const RgbImage constant{3, 2, std::vector<Rgb>(6, Rgb(0.1f, 0.7f, 0.3f))};
    const RgbImage black{3, 2, std::vector<Rgb>(6)};
    for (const Layout layout : {Layout::flat, Layout::directions})
        for (const RgbImage& image : {constant, black}) {
            EXPECT_EQ(LightImage(image, layout).share(), 0);
            EXPECT_EQ(LightImage(image, layout).at({0.3f, 0.9f}).density, 0);
        }
    // Half of the light is above the mean (1 of 0 and 2), where nodes lie in equal numbers.
    RgbImage stripes{8, 1, {}};
    for (int i = 0; i < 8; ++i) stripes.pixels.push_back(Rgb(i < 4 ? 1.0f : 3.0f));
    EXPECT_NEAR(LightImage(stripes, Layout::directions).share(), 0.25f, 1e-6f);
    RgbImage sun{8, 8, std::vector<Rgb>(64, Rgb(1))};
    sun.pixels[20] = Rgb(1e6f);
    EXPECT_EQ(LightImage(sun, Layout::directions).share(), 0.5f) << "never more";
}

// Pixels at the ends of the range of floats: no infinite sum, no NaN.
TEST(LightImage, HugeAndTinyPixels) {
    for (const float scale : {1e38f, 1e-40f}) {
        RgbImage image = noise(5, 4, 1);
        for (Rgb& pixel : image.pixels) pixel *= scale;
        const LightImage light(image, Layout::directions);
        EXPECT_GT(light.share(), 0.1f);
        for (int k = 0; k < 100; ++k) {
            const Vec2 uv = light.draw(test::random_point(1, k));
            EXPECT_TRUE(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1);
            EXPECT_GT(light.at(uv).density, 0);
        }
    }
}

TEST(LightImage, HashSeesSizeAndPixels) {
    const RgbImage image = noise(6, 2, 4);
    const std::uint64_t hash = LightImage(image, Layout::flat).hash();
    EXPECT_EQ(LightImage(image, Layout::directions).hash(), hash);
    RgbImage turned = image, changed = image;
    std::swap(turned.width, turned.height);
    changed.pixels[11].b = std::nextafter(changed.pixels[11].b, 1.0f);
    EXPECT_NE(LightImage(turned, Layout::flat).hash(), hash);
    EXPECT_NE(LightImage(changed, Layout::flat).hash(), hash);
}

}  // namespace
}  // namespace tallow
