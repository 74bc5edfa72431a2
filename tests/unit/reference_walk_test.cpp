// SPDX-License-Identifier: Apache-2.0
#include "experiments/reference/walk.h"

#include <gtest/gtest.h>

#include "tests/support/ball_mesh.h"
#include "tests/support/reference_world.h"

namespace tallow::reference {
namespace {

using test::ReferenceWorld;

Camera far_camera() { return {"far", {0, 0, 60}, {0, 0, 0}, {0, 1, 0}, 0.4f, 4, 4}; }

SphereSurface ball(float radius, Vec3 center = Vec3(0)) { return {{glm::mat3(radius), center}}; }

struct End {
    Walker walker;
    bool left = false;  // to where there is nothing
};

End follow(const Bodies& bodies, std::uint64_t i) {
    WalkRandom random(3, i);
    const float z = 2 * random.next() - 1, phi = kTwoPi * random.next(), s = std::sqrt(1 - z * z);
    const Vec3 from = 40.0f * Vec3(s * std::cos(phi), s * std::sin(phi), z);
    const Vec3 to(4 * random.next() - 2, 4 * random.next() - 2, 4 * random.next() - 2);
    End end{{from, glm::normalize(to - from), 1}};
    walk(
        bodies, 0, end.walker, random,
        [&](const Walker&, float length) { end.left = std::isinf(length); },
        [](std::uint32_t, const auto&, const Walker&, Vec3) { return Next::go_on; });
    return end;
}

// Without absorption all light leaves again, and none is lost through the mesh.
TEST(ReferenceWalk, LosesNoLight) {
    const Medium clear{Rgb(0), Rgb(0.4f), 0.5f, 1.5f};
    for (const Surface& surface : {Surface(test::bumpy_mesh(3)), Surface(ball(9))}) {
        const ReferenceWorld made({surface}, clear, {EnvironmentLight{Rgb(1)}}, far_camera());
        std::uint64_t collisions = 0;
        for (std::uint64_t i = 0; i < 4000; ++i) {
            const End end = follow(*made.bodies, i);
            EXPECT_TRUE(end.left) << i;
            EXPECT_EQ(end.walker.leaks, 0u) << i;
            EXPECT_EQ(end.walker.power, 1);
            collisions += end.walker.collisions;
        }
        EXPECT_GT(collisions, 10000u);
    }
}

// Beer's law along the axis of an index-matched ball, which scatters nothing.
TEST(ReferenceWalk, AbsorbsByBeersLaw) {
    const Medium ink{Rgb(0.1f), Rgb(0), 0, 1};
    Camera camera = far_camera();
    camera.fov = 1e-3f;
    const ReferenceWorld made({ball(10)}, ink, {EnvironmentLight{Rgb(1)}}, camera);
    const test::LayerMeans counted = test::camera_means(made.world(), 8, 400);
    EXPECT_NEAR(counted.mean[mirror], std::exp(-2.0), 4 * counted.error[mirror]);
    EXPECT_LT(counted.error[mirror], 3e-3);
    EXPECT_EQ(counted.mean[multi] + counted.mean[ext], 0);
}

TEST(ReferenceWalk, LayersFollowCollisionsAndArrivals) {
    EXPECT_EQ(layer_of(0, 3), mirror);
    EXPECT_EQ(layer_of(1, 1), single);
    EXPECT_EQ(layer_of(2, 1), multi);
    EXPECT_EQ(layer_of(1, 2), ext);
    EXPECT_EQ(layer_of(9, 2), ext);
}

TEST(ReferenceWalk, RandomNumbersAreEvenAndOpen) {
    WalkRandom random(1, 2);
    double sum = 0, squares = 0, log_sum = 0;
    constexpr int kDraws = 1 << 18;
    for (int i = 0; i < kDraws; ++i) {
        const float u = random.next();
        ASSERT_GT(u, 0);
        ASSERT_LT(u, 1);
        sum += double(u), squares += double(u * u), log_sum -= std::log(double(u));
    }
    EXPECT_NEAR(sum / kDraws, 0.5, 4 * 0.2887 / 512);
    EXPECT_NEAR(squares / kDraws, 1.0 / 3, 4 * 0.298 / 512);
    EXPECT_NEAR(log_sum / kDraws, 1, 4.0 / 512);
}

}  // namespace
}  // namespace tallow::reference
