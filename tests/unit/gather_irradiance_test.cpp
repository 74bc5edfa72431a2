// SPDX-License-Identifier: Apache-2.0
#include "precompute/gather_irradiance.h"

#include <gtest/gtest.h>

#include "common/optics/fresnel.h"
#include "precompute/choose_light_samples.h"
#include "tests/support/scenes.h"

namespace tallow {
namespace {

using test::ceiling;
using test::lit_scene;

constexpr int kManyRays = 1 << 14;

// One sample at the origin that faces up.
SurfaceSamples one_sample(Vec3 normal = {0, 1, 0}) { return {{Vec3(0)}, {normal}, {1}, {Vec3(0)}}; }

GroupIrradiance gather(const Scene& scene, float eta, std::span<const Surface> blockers = {},
                       const SurfaceSamples& samples = one_sample()) {
    const RayScene rays(blockers);
    Progress quiet(true);
    return gather_irradiance(scene, rays, samples, eta,
                             equal_light_samples(scene, scene.settings.light_samples.value()),
                             quiet)
        .at(0);
}

// Form factor from a surface element to a parallel square of side s, centred above it at height h:
// four times the one to a quarter whose corner is above the element (Siegel, Howell, configuration
// 2 of the catalogue of form factors).
double form_factor(double height, double side) {
    const double x = side / 2 / height, root = std::sqrt(1 + x * x);
    return 4 * (1 / (2 * std::numbers::pi)) * 2 * (x / root) * std::atan(x / root);
}

// At eta = 1 nothing is reflected, so that E_t is the plain irradiance pi L F. Measured 1.6e-5.
TEST(GatherIrradiance, SquareLightGivesItsFormFactor) {
    for (float height : {0.5f, 2.0f, 20.0f}) {
        const Scene scene = lit_scene({ceiling(height, 3, {1, 2, 4})}, kManyRays);
        const double E = std::numbers::pi * form_factor(height, 3);
        const Rgb got = gather(scene, 1).E_t[0];
        EXPECT_NEAR(got.r, E, 1e-4 * E) << height;
        EXPECT_NEAR(got.g, 2 * E, 2e-4 * E);
        EXPECT_NEAR(got.b, 4 * E, 4e-4 * E);
    }
}

TEST(GatherIrradiance, SquareLightShinesToOneSide) {
    QuadLight away = ceiling(2, 3, Rgb(1));
    away.normal = -away.normal;
    EXPECT_EQ(gather(lit_scene({away}), 1).E_t[0], Rgb(0));
}

// A sphere that is wholly above the horizon: E = pi L (R / d)^2 cos.
TEST(GatherIrradiance, SphereLight) {
    const Scene scene = lit_scene({SphereLight{{3, 4, 0}, 2, Rgb(1)}}, kManyRays);
    const double E = std::numbers::pi * 4.0 / 25 * 0.8;
    EXPECT_NEAR(gather(scene, 1).E_t[0].r, E, 3e-4 * E);
}

TEST(GatherIrradiance, PointSpotAndDirectionalLights) {
    const Vec3 above(0, 4, 0), down(0, -1, 0);
    EXPECT_NEAR(gather(lit_scene({PointLight{above, Rgb(32)}}), 1).E_t[0].r, 2, 1e-6);
    EXPECT_NEAR(gather(lit_scene({PointLight{{3, 4, 0}, Rgb(25)}}), 1).E_t[0].r, 0.8, 1e-6);
    EXPECT_NEAR(gather(lit_scene({DirectionalLight{down, Rgb(3)}}), 1).E_t[0].r, 3, 1e-6);
    // On the axis; outside the cone; half-way through the cubic step.
    EXPECT_NEAR(gather(lit_scene({SpotLight{above, down, Rgb(32), 0.9f, 0.8f}}), 1).E_t[0].r, 2,
                1e-6);
    const Vec3 aside(std::sqrt(1 - 0.7f * 0.7f), -0.7f, 0),
        half(std::sqrt(1 - 0.85f * 0.85f), -0.85f, 0);
    EXPECT_EQ(gather(lit_scene({SpotLight{above, aside, Rgb(32), 0.9f, 0.8f}}), 1).E_t[0].r, 0);
    EXPECT_NEAR(gather(lit_scene({SpotLight{above, half, Rgb(32), 0.9f, 0.8f}}), 1).E_t[0].r, 1,
                1e-5);
}

TEST(GatherIrradiance, EnvironmentIsWeightedWithTheMeanTransmittance) {
    const Scene scene = lit_scene({EnvironmentLight{Rgb(1)}}, kManyRays);
    EXPECT_NEAR(gather(scene, 1).E_t[0].r, kPi, 1e-3);
    const double E = std::numbers::pi * diffuse_fresnel_transmittance(1.5);
    EXPECT_NEAR(gather(scene, 1.5f).E_t[0].r, E, 3e-4 * E);
}

TEST(GatherIrradiance, TransmittanceAndRefractionOfParallelLight) {
    const float cos_i = 0.5f, sin_i = std::sqrt(0.75f), eta = 1.5f;
    const GroupIrradiance got =
        gather(lit_scene({DirectionalLight{{sin_i, -cos_i, 0}, Rgb(1)}}), eta);
    EXPECT_NEAR(got.E_t[0].r, cos_i * fresnel_transmittance(eta, cos_i), 1e-6);
    // Travels on to +x, bent towards the normal: sin_t = sin_i / eta.
    EXPECT_NEAR(got.w_i[0].x, sin_i / eta, 1e-6);
    EXPECT_NEAR(got.w_i[0].y, -std::sqrt(1 - 0.75f / (eta * eta)), 1e-6);
}

TEST(GatherIrradiance, MeanDirectionIsWeightedWithIrradiance) {
    // Equal angles from both sides, the left light three times as strong.
    const float s = std::sqrt(0.5f);
    const Scene scene =
        lit_scene({DirectionalLight{{s, -s, 0}, Rgb(3)}, DirectionalLight{{-s, -s, 0}, Rgb(1)}});
    EXPECT_NEAR(gather(scene, 1).w_i[0].x, s * (3 - 1) / 4, 1e-6);
}

// A disc over the half x > 0 of a square light's rays: what is left is exactly half.
TEST(GatherIrradiance, ShadowsOfAnObstacle) {
    TriangleMesh wall;  // covers x > 0 at half height, larger than the light appears there
    wall.vertices = {{0, 1, -9}, {9, 1, -9}, {9, 1, 9}, {0, 1, 9}};
    wall.triangles = {{0, 1, 2}, {0, 2, 3}};
    const std::vector<Surface> blockers = {wall};
    const Scene scene = lit_scene({ceiling(2, 3, Rgb(1))}, kManyRays);
    const float open = gather(scene, 1).E_t[0].r;
    EXPECT_NEAR(gather(scene, 1, blockers).E_t[0].r, open / 2, 1e-3 * open);
}

TEST(GatherIrradiance, NothingFromBelowTheHorizon) {
    const Scene scene =
        lit_scene({PointLight{{0, -4, 0}, Rgb(1)}, SphereLight{{0, -9, 0}, 1, Rgb(1)}});
    const GroupIrradiance got = gather(scene, 1.5f);
    EXPECT_EQ(got.E_t[0], Rgb(0));
    EXPECT_EQ(got.w_i[0], Vec3(0));
}

TEST(GatherIrradiance, GroupsAreKeptApart) {
    Scene scene =
        lit_scene({DirectionalLight{{0, -1, 0}, Rgb(1)}, DirectionalLight{{0, -1, 0}, Rgb(2)}});
    scene.groups.push_back({"second", Rgb(100)});  // scales are not applied here
    scene.lights[1].group = 1;
    const RayScene rays({});
    Progress quiet(true);
    const auto groups = gather_irradiance(scene, rays, one_sample(), 1, {1, 1}, quiet);
    EXPECT_EQ(groups.at(0).E_t[0], Rgb(1));
    EXPECT_EQ(groups.at(1).E_t[0], Rgb(2));
}

// Results do not depend on how the samples are cut into ranges of blocks.
TEST(GatherIrradiance, RangesGiveTheWhole) {
    SurfaceSamples samples;
    for (int i = 0; i < 300; ++i) {
        samples.position.push_back({0.01f * float(i), 0, 0.003f * float(i * i % 97)});
        samples.normal.push_back({0, 1, 0});
        samples.area.push_back(1);
    }
    samples.ray_origin = samples.position;
    const std::vector<Surface> blockers = {SphereSurface{{glm::mat3(0.5f), Vec3(1, 1.5f, 0)}}};
    const RayScene rays(blockers);
    const Scene scene = lit_scene({ceiling(4, 3, Rgb(1)), EnvironmentLight{Rgb(1)}});
    const LightSampleCounts counts = {4, 3};
    Progress quiet(true);
    const auto whole = gather_irradiance(scene, rays, samples, 1.3f, counts, quiet);
    std::vector<GroupIrradiance> parts = {{std::vector<Rgb>(300), std::vector<Vec3>(300)}};
    for (const SampleSpan span : {SampleSpan{192, 300}, SampleSpan{0, 64}, SampleSpan{64, 192}})
        gather_irradiance_range(scene, rays, samples, 1.3f, counts, span, parts, quiet);
    EXPECT_EQ(parts[0].E_t, whole[0].E_t);
    EXPECT_EQ(parts[0].w_i, whole[0].w_i);
}

}  // namespace
}  // namespace tallow
