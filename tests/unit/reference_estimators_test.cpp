// SPDX-License-Identifier: Apache-2.0
// The combined estimator against closed forms and against walks from the camera alone. Errors come
// from 16 batches, so that a right estimator is more than 4 of them off once in 900 comparisons;
// the seeds are fixed.
#include <gtest/gtest.h>

#include "common/optics/fresnel.h"
#include "common/optics/phase.h"
#include "tests/support/ball_mesh.h"
#include "tests/support/reference_world.h"

namespace tallow::reference {
namespace {

using test::LayerMeans;
using test::ReferenceWorld;

SphereSurface ball(float radius, Vec3 center = Vec3(0)) { return {{glm::mat3(radius), center}}; }

/// Sees nothing but the middle of a body of radius 10.
Camera close_camera() { return {"close", {6, 7, 40}, {0, 0, 0}, {0, 1, 0}, 0.3f, 8, 8}; }
/// Sees a body of radius 10 with its borders.
Camera whole_camera() { return {"whole", {6, 7, 40}, {0, 0, 0}, {0, 1, 0}, 0.7f, 16, 16}; }

double sum_of(const LayerMeans& means) {
    return means.mean[single] + means.mean[multi] + means.mean[ext] + means.mean[mirror];
}
double error_of(const LayerMeans& means) {
    double sum = 0;
    for (double e : means.error) sum += e * e;
    return std::sqrt(sum);
}

// In light of radiance 1 from everywhere, a body that absorbs nothing is as bright as its surround.
TEST(ReferenceEstimators, WhiteFurnace) {
    for (float eta : {1.0f, 1.5f})
        for (const Surface& surface : {Surface(test::bumpy_mesh(3)), Surface(ball(10))}) {
            const Medium white{Rgb(0), Rgb(0.5f), 0, eta};
            const ReferenceWorld made({surface}, white, {EnvironmentLight{Rgb(1)}}, close_camera());
            const LayerMeans means = test::combined_means(made.world(), 16, 1 << 10, 4);
            EXPECT_NEAR(sum_of(means), 1, 4 * error_of(means)) << "eta " << eta;
            EXPECT_LT(error_of(means), 0.03);
            EXPECT_GT(means.mean[multi], 0.5);
            const LayerMeans camera = test::camera_means(made.world(), 2, 8);
            EXPECT_NEAR(sum_of(camera), 1, 1e-5);  // every such walk ends at the light
        }
}

/// Layer by layer, for two estimators of the same world.
void expect_same(const ReferenceWorld& made, std::uint32_t walks, std::uint32_t camera_rays) {
    const LayerMeans a = test::combined_means(made.world(), 16, walks, 8);
    const LayerMeans b = test::camera_means(made.world(), 16, camera_rays);
    for (std::size_t layer = 0; layer < kLayers; ++layer)
        EXPECT_NEAR(a.mean[layer], b.mean[layer], 4 * std::hypot(a.error[layer], b.error[layer]))
            << "layer " << layer;
    EXPECT_LT(std::hypot(error_of(a), error_of(b)), 0.06 * sum_of(b));
}

QuadLight big_quad() {
    return {{-30, 20, -25}, {0, 0, 60}, {36, 54, 0}, glm::normalize(Vec3(54, -36, 0)), Rgb(3)};
}

TEST(ReferenceEstimators, AgreeOnASphere) {
    const Medium medium{{0.02f, 0.05f, 0.1f}, {0.3f, 0.4f, 0.5f}, 0, 1.5f};
    expect_same(ReferenceWorld({ball(10)}, medium,
                               {EnvironmentLight{{0.1f, 0.2f, 0.3f}}, big_quad()}, whole_camera()),
                1 << 12, 32);
}

// A body with hollows, one of several in each other's light, and a forward phase function.
TEST(ReferenceEstimators, AgreeOnMeshesThatLightEachOther) {
    const Medium medium{{0.02f, 0.05f, 0.1f}, {0.2f, 0.3f, 0.4f}, 0.6f, 1.3f};
    const Surface bumpy = test::bumpy_mesh(3);
    const Affine aside{glm::mat3(0.5f), Vec3(12, 6, 10)};
    const Surface small = transform_mesh(std::get<TriangleMesh>(bumpy), aside);
    for (const std::vector<Surface>& bodies :
         {std::vector<Surface>{bumpy}, std::vector<Surface>{bumpy, small, ball(3, {-6, 3, 13})}})
        expect_same(ReferenceWorld(bodies, medium, {EnvironmentLight{Rgb(0.5f)}, big_quad()},
                                   whole_camera()),
                    1 << 12, 24);
}

// Single scattering of a half-space in parallel light,
//
//     L = alpha p T_i T_o E cos_i / (eta^2 (mu_i' + mu_o')),
//
// by a deep cube under a distant lamp.
TEST(ReferenceEstimators, SingleScatteringOfAHalfSpace) {
    const Medium medium{Rgb(3), Rgb(2), 0, 1.4f};
    const TriangleMesh cube = cube_mesh({glm::mat3(10), Vec3(0, -5, 0)});
    const float distance = 4000, side = 200, radiance = 400;
    const Vec3 w_i = glm::normalize(Vec3(0.6f, 0.7f, 0.2f));
    const Frame frame = make_frame(-w_i);
    const QuadLight lamp{distance * w_i, side * frame.s, side * frame.t, -w_i, Rgb(radiance)};
    const Vec3 w_o = glm::normalize(Vec3(-0.3f, 0.8f, 0.6f));
    const Camera camera{"c", 400.0f * w_o, {0, 0, 0}, {0, 1, 0}, 0.01f, 2, 2};
    const ReferenceWorld made({Surface(cube)}, medium, {lamp}, camera);
    const LayerMeans means = test::combined_means(made.world(), 16, 1 << 14, 4);

    const float E = radiance * side * side / (distance * distance);
    const float eta = medium.eta, mu_i = refracted_cosine(eta, w_i.y);
    const float mu_o = refracted_cosine(eta, w_o.y);
    const float expected = medium.albedo()[0] / (4 * kPi) * fresnel_transmittance(eta, w_i.y) *
                           fresnel_transmittance(eta, w_o.y) * E * w_i.y /
                           (eta * eta * (mu_i + mu_o));
    EXPECT_NEAR(means.mean[single], double(expected), 4 * means.error[single]);
    EXPECT_LT(means.error[single], 0.02 * double(expected));
    EXPECT_EQ(means.mean[ext], 0);
}

TEST(ReferenceEstimators, FollowSeedsAndNothingElse) {
    const ReferenceWorld made({ball(10)}, test::marble(), {big_quad()}, whole_camera());
    const StartMaps starts = learn_starts(made.world(), 1, 256);
    Film a(256), b(256), c(256);
    add_light_walks(made.world(), starts, 5, 512, a);
    add_light_walks(made.world(), starts, 5, 512, b);
    add_light_walks(made.world(), starts, 6, 512, c);
    EXPECT_EQ(a.of(multi, 1), b.of(multi, 1));
    EXPECT_NE(a.of(multi, 1), c.of(multi, 1));
}

}  // namespace
}  // namespace tallow::reference
