// SPDX-License-Identifier: Apache-2.0
// Light that is reflected inside a body, on its way to the place where it scatters and from there
// to the eye: a slab under normal incidence, where both are geometric series.
#include "render/inner_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/parallel.h"
#include "common/optics/fresnel.h"
#include "render/eye_path.h"
#include "tests/support/ball_mesh.h"
#include "tests/support/scenes.h"

namespace tallow {
namespace {

constexpr float kThickness = 1, kSide = 12;

/// A slab whose upper side is y = 0, with entry points on all sides.
struct Slab {
    Medium medium;
    std::vector<Surface> surfaces{cube_mesh(
        {glm::mat3(kSide, 0, 0, 0, kThickness, 0, 0, 0, kSide), Vec3(0, -kThickness / 2, 0)})};
    RayScene rays{surfaces};
    RefractedConnections connections;
    Scene scene = test::lit_scene({DirectionalLight{{0, -1, 0}, Rgb(1)}});
    std::vector<Vec3> positions, normals;
    std::vector<float> areas;

    explicit Slab(float eta)
        : medium{{0.1f, 0.2f, 0.5f}, {0.4f, 0.8f, 1.5f}, 0, eta}, connections(surfaces[0], eta) {
        const Vec3 half(kSide / 2, kThickness / 2, kSide / 2), center(0, -kThickness / 2, 0);
        for (int axis = 0; axis < 3; ++axis)
            for (const float side : {-1.0f, 1.0f}) cover(center, half, axis, side);
    }
    /// Entry points on one side of the slab.
    void cover(Vec3 center, Vec3 half, int axis, float side) {
        constexpr int kPoints = 50;
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        for (int i = 0; i < kPoints * kPoints; ++i) {
            Vec3 p(0), n(0);
            p[axis] = side, n[axis] = side;
            p[a] = 2 * (float(i % kPoints) + 0.5f) / kPoints - 1;
            p[b] = 2 * (float(i / kPoints) + 0.5f) / kPoints - 1;
            positions.push_back(center + p * half), normals.push_back(n);
            areas.push_back(4 * half[a] * half[b] / (kPoints * kPoints));
        }
    }
    ScatteringBody body() const { return {scene, rays, surfaces[0], 0, medium, &connections}; }
    InnerLight inner() const { return InnerLight(body(), {positions, normals, areas}, 0); }
    double reflectance() const {
        const double r = (double(medium.eta) - 1) / (double(medium.eta) + 1);
        return r * r;
    }
    /// Light of irradiance 1 on the slab at depth z, after `least` and more inner reflections; by
    /// reciprocity also what an eye sees of the depth.
    double light_at(double z, int c, int least) const {
        const double sigma = double(medium.sigma_t()[c]), H = kThickness, r = reflectance();
        double sum = 0;
        for (int k = least; k < least + 20; ++k) {
            const double way = k % 2 == 0 ? k * H + z : (k + 1) * H - z;
            sum += std::pow(r, k) * std::exp(-sigma * way);
        }
        return (1 - r) * sum;
    }
};

// Measured: within 1 %, blurred over half a mean free path and noise.
TEST(InnerLight, FluenceInASlab) {
    const Slab slab(2.2f);
    const InnerLight inner = slab.inner();
    ASSERT_FALSE(inner.empty());
    for (int c = 0; c < 3; ++c) {
        double mean = 0, expected = 0;
        constexpr int kDepths = 200;
        for (int k = 0; k < kDepths; ++k) {
            const double z = (k + 0.5) / kDepths * double(kThickness);
            const float x = 0.02f * float(k) - 2;
            mean += double(inner.fluence({x, float(-z), -x})[c]) / kDepths;
            expected += slab.light_at(z, c, 1) / kDepths;
        }
        EXPECT_NEAR(mean, expected, 0.02 * expected) << c;
    }
    EXPECT_GT(inner.share(), 0.02);
}

// The layer as a whole against quadrature over the depth. Measured: within 0.5 %.
TEST(InnerLight, SingleScatteringOfASlabWithReflections) {
    for (const float eta : {1.3f, 2.2f}) {
        const Slab slab(eta);
        const InnerLight inner = slab.inner();
        ScatteringBody body = slab.body();
        body.inner = &inner;
        Rgb L;
        constexpr int kPoints = 64;
        for (int i = 0; i < kPoints; ++i) {
            const Vec3 p(0.05f * float(i) - 1.6f, 0, 0.3f - 0.03f * float(i));
            const Hit hit{1, 0, p, {0, 1, 0}, {0, 1, 0}};
            L += single_scatter(body, {hit, {0, 1, 0}, std::uint64_t(i)}, lone_steps(64)) / kPoints;
        }
        for (int c = 0; c < 3; ++c) {
            constexpr int kSteps = 2000;
            double expected = 0;
            for (int k = 0; k < kSteps; ++k) {
                const double z = (k + 0.5) / kSteps * double(kThickness);
                expected +=
                    slab.light_at(z, c, 0) * slab.light_at(z, c, 0) * double(kThickness) / kSteps;
            }
            expected *= double(slab.medium.sigma_s()[c]) / (4 * double(kPi) * double(eta * eta));
            EXPECT_NEAR(double(L[c]), expected, 0.01 * expected) << eta << ' ' << c;
        }
    }
}

// A wedge of light that is reflected totally: the segments of an eye ray in a cube go on with all
// that absorption leaves.
TEST(InnerLight, EyeRaysAreReflectedInside) {
    const Slab slab(1.5f);
    const Vec3 w_o = glm::normalize(Vec3(2, 1, 0));
    const Hit hit{1, 0, Vec3(0), {0, 1, 0}, {0, 1, 0}};
    const EyePoint eye{hit, w_o, 1};
    const auto segments = follow_eye_rays(slab.body(), {&eye, 1});
    ASSERT_GE(segments.size(), 2u);
    const float cosine = refracted_cosine(1.5f, w_o.y);
    EXPECT_NEAR(segments[0].length, kThickness / cosine, 1e-4f);
    EXPECT_NEAR(segments[1].direction.y, cosine, 1e-5f);
    const float reflectance = fresnel_reflectance(1 / 1.5f, cosine);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(segments[1].throughput[c],
                    reflectance * std::exp(-slab.medium.sigma_t()[c] * segments[0].length), 1e-5f);
}

// A ball of many mean free paths has nothing of it, and says so after a few rays.
TEST(InnerLight, IsLeftOutWhereLightDoesNotCross) {
    Slab slab(1.5f);
    slab.medium.sigma_s_prime = Rgb(40);
    const InnerLight inner(slab.body(), {slab.positions, slab.normals, slab.areas}, 1e-3);
    EXPECT_TRUE(inner.empty());
    EXPECT_LT(inner.share(), 1e-6);
}

TEST(InnerLight, IsTheSameForAnyNumberOfThreads) {
    const Slab slab(1.5f);
    std::vector<Rgb> values[2];
    for (int k = 0; k < 2; ++k) {
        const ThreadLimit limit(k == 0 ? 1 : 3);
        const InnerLight inner = slab.inner();
        for (int i = 0; i < 300; ++i)
            values[k].push_back(inner.fluence({0.03f * float(i) - 4.5f, -0.003f * float(i), 0.1f}));
    }
    EXPECT_EQ(values[0], values[1]);
}

}  // namespace
}  // namespace tallow
