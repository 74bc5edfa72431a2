// SPDX-License-Identifier: Apache-2.0
// Light from all directions: where a picture's pixels are seen, what they bring, and how much less
// noise there is for knowing where they are bright.
#include <gtest/gtest.h>

#include "tests/support/light_estimates.h"

namespace tallow {
namespace {

using test::Estimate;

constexpr double kPiD = std::numbers::pi;

EnvironmentLight environment(RgbImage image, float rotation = 0, Rgb scale = Rgb(1)) {
    return {scale,
            std::make_shared<const LightImage>(std::move(image), LightImage::Layout::directions),
            rotation};
}

/// A picture of f(direction), made as the grammar of scenes describes it.
template <class F>
RgbImage picture_of(int width, int height, F&& f) {
    RgbImage image{width, height, {}};
    for (int j = 0; j < height; ++j)
        for (int i = 0; i < width; ++i) {
            const double theta = kPiD * (j + 0.5) / height;
            const double longitude = kPiD - 2 * kPiD * (i + 0.5) / width;
            image.pixels.push_back(f(DVec3(std::sin(theta) * std::sin(longitude), std::cos(theta),
                                           std::sin(theta) * std::cos(longitude))));
        }
    return image;
}

/// Brighter towards the horizon, dark below it, and a sun of 2 degrees with `sun` times its flux.
RgbImage sky_picture(double sun) {
    const DVec3 to_sun = glm::normalize(DVec3(0.5, 0.7, 0.5));
    const double cos_sun = std::cos(glm::radians(2.0));
    // Flux of the sky: 2 pi (0.3 + 0.7 / 2 + 0.1); of the disc: 2 pi (1 - cos).
    const double L_sun = sun * 0.75 / (1 - cos_sun);
    return picture_of(256, 128, [&](DVec3 w) {
        const double sky = w.y > 0 ? 0.3 + 0.7 * (1 - w.y) : 0.1;
        return Rgb(float(sky + (glm::dot(w, to_sun) > cos_sun ? L_sun : 0)));
    });
}

std::vector<Vec3> normals_of_a_cube() {
    std::vector<Vec3> normals;
    for (int i = 0; i < 27; ++i)
        if (i != 13) normals.push_back(glm::normalize(Vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
    return normals;
}

/// Variance of one sample over the square of its mean, mean over the normals.
template <class F>
double relative_variance(F&& estimate_for) {
    double sum = 0;
    for (const Vec3 n : normals_of_a_cube()) {
        const Estimate e = estimate_for(n);
        sum += e.variance.x / (e.mean.x * e.mean.x) / 26;
    }
    return sum;
}

TEST(Environment, DirectionsOfPixels) {
    // Thirds of latitude, quarters of longitude.
    RgbImage image{4, 3, {}};
    for (int i = 0; i < 12; ++i) image.pixels.push_back(Rgb(float(i)));
    const auto seen = [&](const EnvironmentLight& light, Vec3 w) {
        return see_light({light}, {Vec3(7, 8, 9), glm::normalize(w)})->radiance.r;
    };
    const EnvironmentLight light = environment(image);
    // Centres of the middle row: longitudes 135, 45, -45, -135 degrees from +z towards +x.
    EXPECT_NEAR(seen(light, {1, 0, -1}), 4, 1e-5f);
    EXPECT_NEAR(seen(light, {1, 0, 1}), 5, 1e-5f);
    EXPECT_NEAR(seen(light, {-1, 0, 1}), 6, 1e-5f);
    EXPECT_NEAR(seen(light, {-1, 0, -1}), 7, 1e-5f);
    EXPECT_NEAR(seen(light, {0, 0, 1}), 5.5f, 1e-5f) << "the middle";
    EXPECT_NEAR(seen(light, {0, 0, -1}), 5.5f, 1e-5f) << "the seam: the mean of 4 and 7";
    EXPECT_LT(seen(light, {0.01f, 1, 0.02f}), 4) << "up is the first row";
    EXPECT_GT(seen(light, {0.01f, -1, 0.02f}), 7);
    // Turned by 90 degrees from +z towards +x, the middle is seen towards +x.
    const EnvironmentLight turned = environment(image, kPi / 2);
    EXPECT_NEAR(seen(turned, {1, 0, 0}), 5.5f, 1e-5f);
    EXPECT_NEAR(seen(turned, {1, 0, -1}), 5, 1e-5f);
}

// L = c gives E = pi c for every normal, by the same samples as without a picture.
TEST(Environment, FurnaceOfAConstantPicture) {
    const Light light{environment({6, 3, std::vector<Rgb>(18, Rgb(2))}, 1, Rgb(1, 0.5f, 3))};
    for (const Vec3 n : normals_of_a_cube()) {
        const Estimate e = test::random_irradiance(light, Vec3(0), n, 100);
        EXPECT_NEAR(e.mean.x, 2 * kPiD, 1e-5);
        EXPECT_NEAR(e.mean.z, 6 * kPiD, 1e-5);
        EXPECT_LT(e.variance.x, 1e-10);
    }
}

// L = 1 + w_y gives, facing up, E = pi + 2 pi / 3; facing +x it gives pi; from all directions 4 pi.
TEST(Environment, CosineMoments) {
    const Light light{
        environment(picture_of(256, 128, [](DVec3 w) { return Rgb(float(1 + w.y)); }))};
    // Measured 2e-4: a linear function interpolated between 128 rows.
    EXPECT_NEAR(test::irradiance(light, Vec3(0), {0, 1, 0}).x, kPiD * 5 / 3, 1e-3);
    EXPECT_NEAR(test::irradiance(light, Vec3(0), {1, 0, 0}).x, kPiD, 1e-3);
    EXPECT_NEAR(test::irradiance(light, Vec3(0), {0, -1, 0}).x, kPiD / 3, 1e-3);
}

// A sun of one pixel in a black sky is a small light of known flux: E = L omega cos.
TEST(Environment, SunOfOnePixel) {
    RgbImage image{512, 256, std::vector<Rgb>(512 * 256)};
    const int i = 150, j = 70;
    image.pixels[std::size_t(j * 512 + i)] = Rgb(1e4f, 1e3f, 0);
    const double theta = kPiD * (j + 0.5) / 256, longitude = kPiD - 2 * kPiD * (i + 0.5) / 512;
    const double omega = std::sin(theta) * (kPiD / 256) * (kPiD / 256);
    const Vec3 to_sun(float(std::sin(theta) * std::sin(longitude)), float(std::cos(theta)),
                      float(std::sin(theta) * std::cos(longitude)));
    const Light light{environment(image)};
    for (const Vec3 n : {to_sun, Vec3(0, 1, 0)}) {
        const DVec3 E = test::irradiance(light, Vec3(0), n);
        const double expected = 1e4 * omega * glm::dot(to_sun, n);
        EXPECT_NEAR(E.x, expected, 5e-4 * expected);  // measured 5e-5
        EXPECT_NEAR(E.y, expected / 10, 5e-5 * expected);
        EXPECT_EQ(E.z, 0);
    }
    EXPECT_EQ(test::irradiance(light, Vec3(0), -to_sun).x, 0) << "below the horizon";
}

// Against uniform directions and see_light(): the same mean, far less noise.
TEST(Environment, ImportanceSamplingAgainstBruteForce) {
    const Light light{environment(sky_picture(1), 0.3f)};
    const auto uniform = [&](Vec3 n, int count) {
        return test::estimate(count, [&](int k) {
            const Vec2 u = test::random_point(3, k);
            const float z = 1 - 2 * u.x, s = std::sqrt(1 - z * z), phi = kTwoPi * u.y;
            const Vec3 w(s * std::cos(phi), s * std::sin(phi), z);
            const float cosine = std::max(0.0f, glm::dot(w, n));
            return 4 * kPi * cosine * see_light(light, {Vec3(0), w})->radiance;
        });
    };
    const Vec3 n = glm::normalize(Vec3(1, 2, 0.5f));
    const Estimate brute = uniform(n, 4000000);
    const Estimate drawn = test::random_irradiance(light, Vec3(0), n, 100000);
    EXPECT_NEAR(drawn.mean.x, brute.mean.x,
                4 * std::hypot(drawn.mean_error.x, brute.mean_error.x));  // 4 sigma
    EXPECT_LT(brute.mean_error.x, 0.02 * brute.mean.x);
    // Measured 4200: so many more uniform directions are needed for the same noise.
    EXPECT_GT(brute.variance.x / drawn.variance.x, 2000);
}

// The numbers in light_environment.cpp, here from samples.
TEST(Environment, NoiseOfTheMixture) {
    struct Row {
        double sun, most;  // measured 0.64, 0.91, 1.58, 1.88
    };
    for (const Row& row : {Row{0, 0.7}, Row{0.3, 1}, Row{1, 1.7}, Row{10, 2.1}}) {
        const Light light{environment(sky_picture(row.sun))};
        EXPECT_LT(relative_variance(
                      [&](Vec3 n) { return test::random_irradiance(light, Vec3(0), n, 20000); }),
                  row.most)
            << "sun " << row.sun;
    }
}

// 16 points of the sequence a light and receiver, as scenes use them by default.
TEST(Environment, StratifiedPointsHelp) {
    const Light light{environment(sky_picture(1))};
    const Vec3 n = glm::normalize(Vec3(0.2f, 1, 0));
    const auto variance_of_16 = [&](auto&& point) {
        return test::estimate(4000, [&](int run) {
            Rgb sum;
            for (int k = 0; k < 16; ++k)
                sum += test::irradiance_sample(light, Vec3(0), n, point(run, k)) / 16;
            return sum;
        });
    };
    const Estimate independent = variance_of_16(
        [](int run, int k) { return test::random_point(std::uint64_t(run) + 100, k); });
    const Estimate stratified = variance_of_16(
        [](int run, int k) { return sobol_2d(std::uint32_t(k), std::uint64_t(run) * 977 + 5); });
    EXPECT_NEAR(stratified.mean.x, independent.mean.x,
                4 * std::hypot(stratified.mean_error.x, independent.mean_error.x));
    EXPECT_GT(independent.variance.x / stratified.variance.x, 6);  // measured 12
}

TEST(Environment, BlackPictureIsDark) {
    const Light light{environment({4, 2, std::vector<Rgb>(8)})};
    EXPECT_FALSE(sample_light(light, Vec3(0), Vec3(0, 1, 0), Vec2(0.3f)));
    EXPECT_FALSE(sample_light(light, Vec3(0), std::nullopt, Vec2(0.3f)));
    EXPECT_EQ(see_light(light, {Vec3(0), Vec3(0, 1, 0)})->radiance, Rgb(0));
    EXPECT_EQ(sample_light_point(light, Vec2(0.3f)).strength, Rgb(0));
}

// Straight up, straight down, along the axes: no NaN where longitudes meet.
TEST(Environment, PolesAndSeams) {
    const Light light{environment(sky_picture(1))};
    for (int i = 0; i < 6; ++i) {
        Vec3 w(0);
        w[i / 2] = i % 2 ? 1.0f : -1.0f;
        EXPECT_TRUE(is_finite(see_light(light, {Vec3(0), w})->radiance)) << i;
        for (const Vec2 u :
             {Vec2(0), Vec2(0.5f, 0), Vec2(0x1.fffffep-1f), Vec2(0, 0x1.fffffep-1f)}) {
            const auto sample = sample_light(light, Vec3(0), w, u);
            EXPECT_TRUE(!sample || (is_finite(sample->radiance) && is_finite(sample->w_i))) << i;
        }
    }
}

}  // namespace
}  // namespace tallow
