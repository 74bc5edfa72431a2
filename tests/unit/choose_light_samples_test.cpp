// SPDX-License-Identifier: Apache-2.0
#include "precompute/choose_light_samples.h"

#include <gtest/gtest.h>

#include "common/base/parallel.h"
#include "tests/support/scenes.h"

namespace tallow {
namespace {

using test::ceiling;
using test::lit_scene;

/// A floor of 128 x 128 samples 0.1 mm apart in Z order, a ball over it.
struct Floor {
    SurfaceSamples samples;
    std::vector<Surface> surfaces = {SphereSurface{{glm::mat3(1.0f), Vec3(4, 1.5f, 4)}}};
    RayScene rays{surfaces};

    Floor() {
        for (std::uint32_t i = 0; i < 128 * 128; ++i) {
            std::uint32_t x = 0, z = 0;
            for (int bit = 0; bit < 7; ++bit) {
                x |= (i >> (2 * bit) & 1) << bit;
                z |= (i >> (2 * bit + 1) & 1) << bit;
            }
            samples.position.push_back(0.1f * Vec3(float(x), 0, float(z)));
        }
        samples.normal.assign(samples.size(), Vec3(0, 1, 0));
        samples.area.assign(samples.size(), 0.01f);
        samples.ray_origin = samples.position;
    }

    LightSampleCounts choose(const Scene& scene, double tolerance, float mfp = 0.3f) const {
        Medium medium{Rgb(0), Rgb(1 / mfp), 0, 1.3f};
        return choose_light_samples(scene, rays, samples, medium, tolerance);
    }
};

const Floor& lit_floor() {
    static const Floor floor;
    return floor;
}

TEST(ChooseLightSamples, LightsWithoutASizeGetOneRay) {
    const Scene scene =
        lit_scene({DirectionalLight{{0, -1, 0}, Rgb(1)}, PointLight{{4, 9, 4}, Rgb(1)}});
    EXPECT_EQ(lit_floor().choose(scene, 1e-4), (LightSampleCounts{1, 1}));
}

TEST(ChooseLightSamples, GrowsWithTheAccuracyAndTheSizeOfTheLight) {
    const Scene small = lit_scene({ceiling(20, 0.5f, Rgb(1))});
    const Scene large = lit_scene({ceiling(20, 30, Rgb(1))});
    const auto rays = [](const Scene& scene, double t) { return lit_floor().choose(scene, t)[0]; };
    EXPECT_LT(rays(large, 0.1), rays(large, 0.01));
    EXPECT_LT(rays(large, 0.01), rays(large, 0.001));
    EXPECT_LT(rays(small, 0.01), rays(large, 0.01));
    EXPECT_EQ(rays(large, 0), 256);
}

// What the exitance averages needs fewer rays a sample.
TEST(ChooseLightSamples, FewerWhereTheExitanceAveragesMore) {
    const Scene scene = lit_scene({ceiling(20, 30, Rgb(1))});
    EXPECT_LT(lit_floor().choose(scene, 0.01, 0.3f)[0], lit_floor().choose(scene, 0.01, 0.01f)[0]);
}

// A dim light may be noisier, but not more than ten times; a dark one is free.
TEST(ChooseLightSamples, DimLightsNeedFewer) {
    const auto two = [](float dim) {
        Scene scene = lit_scene({ceiling(20, 30, Rgb(1)), ceiling(20, 30, Rgb(dim))});
        scene.groups.push_back({"dim", Rgb(1)});
        scene.lights[1].group = 1;
        return lit_floor().choose(scene, 0.003);
    };
    const LightSampleCounts equal = two(1), dim = two(0.01f), dark = two(0);
    EXPECT_LE(equal[0], 2 * equal[1]);  // their sequences differ
    EXPECT_LE(equal[1], 2 * equal[0]);
    EXPECT_LT(dim[1], equal[1]);
    EXPECT_GT(dim[1], 1);
    EXPECT_EQ(dark[1], 1);
}

TEST(ChooseLightSamples, SameForAnyNumberOfThreads) {
    const Scene scene = lit_scene({ceiling(20, 30, Rgb(1)), EnvironmentLight{Rgb(0.2f)}});
    const LightSampleCounts all = lit_floor().choose(scene, 0.005);
    const ThreadLimit one_thread(1);
    EXPECT_EQ(lit_floor().choose(scene, 0.005), all);
}

std::vector<Rgb> gather(const Scene& scene, int rays) {
    Progress quiet(true);
    const Floor& floor = lit_floor();
    return gather_irradiance(scene, floor.rays, floor.samples, 1.3f, {rays}, quiet).at(0).E_t;
}

// relRMSE of the means of 32 samples, which is what the exitance averages at mfp = 0.2829.
double noise_of_patches(const std::vector<Rgb>& noisy, const std::vector<Rgb>& exact) {
    double squares = 0, sum = 0;
    constexpr std::size_t kPatch = 32;
    for (std::size_t first = 0; first < noisy.size(); first += kPatch) {
        double error = 0;
        for (std::size_t i = first; i < first + kPatch; ++i) {
            error += double(noisy[i].r - exact[i].r) / kPatch;
            sum += double(exact[i].r) / double(noisy.size());
        }
        squares += error * error * kPatch / double(noisy.size());
    }
    return std::sqrt(squares) / sum;
}

// What was chosen keeps its promise. Measured, of the allowed: 0.56, 0.76 (by area) and 0.64 (by
// solid angle). A pilot with two sequences of its own, in blocks at the same place of the Morton
// order's squares, had 1.04, 1.47 and 1.44: a sequence that is lucky in one block is in all.
TEST(ChooseLightSamples, NoiseOfPatchesStaysBelowAThirdOfTheTolerance) {
    const double tolerance = 0.01;
    for (const float side : {4.0f, 12.0f, 30.0f}) {
        const Scene scene = lit_scene({ceiling(20, side, Rgb(1))});
        const int chosen = lit_floor().choose(scene, tolerance, 0.2829f)[0];
        ASSERT_GE(chosen, 4);
        const std::vector<Rgb> exact = gather(scene, 128);  // has 0.0005 itself
        const double noise = noise_of_patches(gather(scene, chosen), exact);
        EXPECT_LT(noise, tolerance / 3) << "side " << side << ", rays " << chosen;
        // And no more rays than that takes; measured 1.28 to 1.84.
        EXPECT_GT(noise_of_patches(gather(scene, chosen / 4), exact), tolerance / 3) << side;
        RecordProperty("of the allowed, side " + std::to_string(int(side)),
                       std::to_string(noise / tolerance * 3));
    }
}

}  // namespace
}  // namespace tallow
