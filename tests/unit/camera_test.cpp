// SPDX-License-Identifier: Apache-2.0
#include "common/scene/camera.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace tallow
