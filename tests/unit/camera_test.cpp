// SPDX-License-Identifier: Apache-2.0
#include "common/scene/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tallow {
namespace {

// Looks along -z from (0, 0, 10); 90 degrees high, twice as wide.
const Camera kCamera{"main", {0, 0, 10}, {0, 0, 0}, {0, 1, 0}, kPi / 2, 200, 100};

void expect_direction(float x, float y, Vec3 expected) {
    const Ray ray = camera_ray(kCamera, x, y);
    EXPECT_EQ(ray.origin, kCamera.position);
    EXPECT_NEAR(glm::length(ray.direction), 1, 1e-6f);
    EXPECT_NEAR(glm::distance(ray.direction, glm::normalize(expected)), 0, 1e-6f) << x << ", " << y;
}

TEST(Camera, CentreOfTheImageIsWhereItLooks) { expect_direction(100, 50, {0, 0, -1}); }

// The vertical angle spans the height; x grows to the right, y down; pixels are square.
TEST(Camera, EdgesSpanTheFieldOfView) {
    expect_direction(100, 0, {0, 1, -1});
    expect_direction(100, 100, {0, -1, -1});
    expect_direction(0, 50, {-2, 0, -1});
    expect_direction(200, 50, {2, 0, -1});
    expect_direction(0, 0, {-2, 1, -1});
}

// Only the part of `up` across the direction of view counts, and not its length.
TEST(Camera, UpNeedBeNeitherUnitNorPerpendicular) {
    Camera tilted = kCamera;
    tilted.up = {0, 3, -5};
    const Vec3 expected = camera_ray(kCamera, 30, 20).direction;
    EXPECT_NEAR(glm::distance(camera_ray(tilted, 30, 20).direction, expected), 0, 1e-6f);
}

Camera with_lens(float radius, float focus) {
    Camera camera = kCamera;
    camera.lens_radius = radius, camera.focus = focus;
    return camera;
}

// Whatever part of the lens, an image point's rays meet in the plane that is sharp, where the
// pinhole's ray crosses it: z = 10 - 4.
TEST(ThinLens, RaysOfAnImagePointMeetInTheSharpPlane) {
    const Camera camera = with_lens(0.5f, 4);
    const Vec3 pinhole = camera_ray(kCamera, 31, 77).direction;
    const Vec3 sharp = kCamera.position + 4 / -pinhole.z * pinhole;
    for (const Vec2 u : {Vec2(0.5f), Vec2(0), Vec2(0.9f, 0.2f), Vec2(0.4f, 0.99f)}) {
        const Ray ray = camera_ray(camera, 31, 77, u);
        EXPECT_EQ(ray.origin.z, 10);
        EXPECT_NEAR(glm::length(ray.direction), 1, 1e-6f);
        const Vec3 there = ray.origin + 4 / -ray.direction.z * ray.direction;
        EXPECT_NEAR(glm::distance(there, sharp), 0, 2e-6f) << u.x << ", " << u.y;
    }
}

// A grid of u: means over the disc are known, |x|^2 = radius^2 / 2 and x = y = 0. Measured: 2e-4.
TEST(ThinLens, IsFilledEvenly) {
    constexpr int kGrid = 64;
    double x = 0, y = 0, r2 = 0, largest = 0;
    for (int i = 0; i < kGrid; ++i)
        for (int j = 0; j < kGrid; ++j) {
            const Vec2 u((float(i) + 0.5f) / kGrid, (float(j) + 0.5f) / kGrid);
            const Vec3 o = camera_ray(with_lens(2, 4), 100, 50, u).origin - kCamera.position;
            x += o.x, y += o.y, r2 += length2(o);
            largest = std::max(largest, double(length2(o)));
        }
    constexpr double n = kGrid * kGrid;
    EXPECT_NEAR(x / n, 0, 1e-6);
    EXPECT_NEAR(y / n, 0, 1e-6);
    EXPECT_NEAR(r2 / n, 2, 1e-3);
    EXPECT_LE(largest, 4.0);
    EXPECT_EQ(camera_ray(with_lens(2, 4), 100, 50).origin, kCamera.position);  // the centre
}

TEST(ThinLens, ApertureOfZeroIsThePinhole) {
    for (const Vec2 u : {Vec2(0.5f), Vec2(0.1f, 0.7f)})
        for (const Vec2 p : {Vec2(0), Vec2(12.25f, 63.5f), Vec2(199, 1)}) {
            const Ray pinhole = camera_ray(kCamera, p.x, p.y);
            const Ray ray = camera_ray(with_lens(0, 4), p.x, p.y, u);
            EXPECT_EQ(ray.origin, pinhole.origin);
            EXPECT_EQ(ray.direction, pinhole.direction);
        }
}

}  // namespace
}  // namespace tallow
