// SPDX-License-Identifier: Apache-2.0
// Where cameras are in their frames.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/scene/camera.h"

namespace tallow {
namespace {

Camera turning(Turntable table) {
    Camera camera{"turn", {3, 5, 10}, {1, 2, 4}, {0, 1, 0}, 0.6f, 8, 8};
    camera.motion = table;
    return camera;
}

void expect_near(Vec3 a, Vec3 b, float allowed = 1e-5f) {
    EXPECT_NEAR(glm::distance(a, b), 0, allowed)
        << a.x << ' ' << a.y << ' ' << a.z << " and " << b.x << ' ' << b.y << ' ' << b.z;
}

TEST(Turntable, FirstFrameIsTheCameraItself) {
    const Camera camera = turning({36, glm::normalize(Vec3(1, 2, 3)), kTwoPi});
    const Camera first = camera_at(camera, 0);
    EXPECT_EQ(first.position, camera.position);
    EXPECT_EQ(first.up, camera.up);
    EXPECT_EQ(first.fov, camera.fov);
    EXPECT_EQ(frame_count(camera), 36);
    EXPECT_EQ(frame_count(first), 1);
}

// A quarter to the left about the vertical takes +z to +x.
TEST(Turntable, TurnsRightHandedAboutThePointLookedAt) {
    const Camera quarter = camera_at(turning({4, {0, 1, 0}, kTwoPi}), 1);
    expect_near(quarter.position, {1 + 6, 5, 4 - 2});
    EXPECT_EQ(quarter.look_at, Vec3(1, 2, 4));
    expect_near(quarter.up, {0, 1, 0});
    const Camera half = camera_at(turning({3, {0, 1, 0}, -kTwoPi}), 0);
    EXPECT_EQ(half.position, Vec3(3, 5, 10));
    const Camera rolled = camera_at(turning({4, {0, 0, 1}, kTwoPi}), 1);
    expect_near(rolled.up, {-1, 0, 0});  // `up` turns as well
}

// Frames of a full circle are evenly spread: the one after the last would be the first.
TEST(Turntable, FullCircleDoesNotRepeatItsFirstFrame) {
    const Camera camera = turning({5, {0, 1, 0}, kTwoPi});
    const auto step = [&](int from, int to) {
        return glm::distance(camera_at(camera, from).position, camera_at(camera, to).position);
    };
    for (int frame = 1; frame < 5; ++frame) EXPECT_NEAR(step(frame - 1, frame), step(4, 0), 1e-5f);
}

TEST(Turntable, KeepsAPointInFocus) {
    Camera camera = turning({8, {0, 1, 0}, kTwoPi});
    camera.lens_radius = 1, camera.focus_point = Vec3(1, 2, 5);
    for (int frame = 0; frame < 8; ++frame) {
        const Camera still = camera_at(camera, frame);
        const Vec3 forward = glm::normalize(still.look_at - still.position);
        EXPECT_NEAR(still.focus, glm::dot(Vec3(1, 2, 5) - still.position, forward), 1e-5f);
    }
    EXPECT_GT(camera_at(camera, 4).focus, camera_at(camera, 0).focus);
}

Camera on_way(std::vector<Keyframe> keys) {
    Camera camera{"way", {0, 0, 9}, {0, 0, 0}, {0, 1, 0}, 0.6f, 8, 8};
    camera.motion = std::move(keys);
    return camera;
}

TEST(Keyframes, AreMetExactly) {
    const std::vector<Keyframe> keys = {{2, {0.1f, 0.2f, 9}, {0, 0.3f, 0}, 0.6f},
                                        {5, {4, 1, 7}, {1, 0, 0}, 0.3f},
                                        {11, {8, -1, 2}, {0, 0, 0.7f}, 1.2f}};
    const Camera camera = on_way(keys);
    EXPECT_EQ(frame_count(camera), 12);
    for (const Keyframe& key : keys) {
        const Camera still = camera_at(camera, key.frame);
        EXPECT_EQ(still.position, key.position);
        EXPECT_EQ(still.look_at, key.look_at);
        EXPECT_EQ(still.fov, key.fov);
    }
    EXPECT_EQ(camera_at(camera, 0).position, keys[0].position);  // waits
    EXPECT_EQ(camera_at(camera, 1).fov, keys[0].fov);
}

TEST(Keyframes, OneIsACameraThatStandsStill) {
    const Camera camera = on_way({{3, {1, 2, 3}, {0, 0, 0}, 0.5f}});
    EXPECT_EQ(frame_count(camera), 4);
    for (int frame = 0; frame < 4; ++frame)
        EXPECT_EQ(camera_at(camera, frame).position, Vec3(1, 2, 3));
}

// Evenly along a line, whatever the distances of keyframes.
TEST(Keyframes, KeepAnEvenSpeed) {
    const auto at = [](int frame) { return Vec3(float(frame), 2 * float(frame), 9); };
    const Camera camera = on_way({{0, at(0), {0, 0, 0}, 0.6f},
                                  {2, at(2), {0, 0, 0}, 0.6f},
                                  {9, at(9), {0, 0, 0}, 0.6f},
                                  {12, at(12), {0, 0, 0}, 0.6f}});
    for (int frame = 0; frame <= 12; ++frame) {
        expect_near(camera_at(camera, frame).position, at(frame));
        EXPECT_NEAR(camera_at(camera, frame).fov, 0.6f, 1e-6f);
    }
}

// On a circle with a keyframe every 45 degrees the spline, whose tangents are the chords over two
// segments, is off most half way: there it is cos 22.5 + sin 45 sin 22.5 / 4 = 0.99153 from the
// centre. Speed and direction do not jump at keyframes.
TEST(Keyframes, GoSmoothlyAroundACircle) {
    std::vector<Keyframe> keys;
    for (int k = 0; k < 8; ++k) {
        const float phi = float(k) * kPi / 4;
        keys.push_back({8 * k, {std::cos(phi), 0, std::sin(phi)}, {0, 0, 0}, 0.6f});
    }
    const Camera camera = on_way(keys);
    const auto at = [&](int frame) { return camera_at(camera, frame).position; };
    EXPECT_NEAR(glm::length(at(12)), 0.99153, 1e-5);
    for (int frame = 9; frame <= 47; ++frame) {
        EXPECT_GE(glm::length(at(frame)), 0.9915f) << frame;
        EXPECT_LE(glm::length(at(frame)), 1.0001f) << frame;
        const Vec3 before = at(frame) - at(frame - 1), after = at(frame + 1) - at(frame);
        EXPECT_LT(glm::distance(before, after), 0.15f * glm::length(before)) << frame;
    }
}

// Two equal keyframes hold the camera; Catmull-Rom tangents alone would let it drift.
TEST(Keyframes, ARestIsARest) {
    const Camera camera = on_way({{0, {0, 0, 9}, {0, 0, 0}, 0.6f},
                                  {4, {4, 0, 9}, {0, 1, 0}, 0.4f},
                                  {8, {4, 0, 9}, {0, 1, 0}, 0.4f},
                                  {12, {0, 6, 9}, {0, 0, 0}, 0.6f}});
    for (int frame = 4; frame <= 8; ++frame) {
        EXPECT_EQ(camera_at(camera, frame).position, Vec3(4, 0, 9)) << frame;
        EXPECT_EQ(camera_at(camera, frame).look_at, Vec3(0, 1, 0)) << frame;
        EXPECT_NEAR(camera_at(camera, frame).fov, 0.4f, 1e-7f) << frame;
    }
}

// Overshooting between extreme keyframes stays a field of view.
TEST(Keyframes, ZoomsStayPossible) {
    const Camera camera = on_way({{0, {0, 0, 9}, {0, 0, 0}, 0.001f},
                                  {9, {0, 0, 9}, {0, 0, 0}, 3.14f},
                                  {18, {0, 0, 9}, {0, 0, 0}, 3.13f},
                                  {27, {0, 0, 9}, {0, 0, 0}, 0.001f}});
    for (int frame = 0; frame <= 27; ++frame) {
        EXPECT_GT(camera_at(camera, frame).fov, 0) << frame;
        EXPECT_LT(camera_at(camera, frame).fov, kPi) << frame;
    }
}

}  // namespace
}  // namespace tallow
