// SPDX-License-Identifier: Apache-2.0
// A scene far from its file's origin is rendered around an origin of its own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/scene/scene_geometry.h"
#include "tests/support/scene_text.h"

namespace tallow {
namespace {

// The same ball, light and camera, `offset` mm along x.
Scene moved_scene(double offset) {
    const auto x = [&](double value) { return fmt::format("{:.6f}", value + offset); };
    return scene_of(fmt::format(
        "cameras: {{main: {{type: perspective, position: [{}, 0, 10], look_at: [{}, 0, 0], "
        "fov_deg: "
        "40, resolution: [4, 3]}}}}\n"
        "materials: {{wax: {{type: subsurface, preset: marble}}}}\n"
        "objects:\n"
        "- {{shape: sphere, center: [{}, 0, 0], radius: 1, material: wax}}\n"
        "- {{shape: cube, size: 1, material: wax, transform: [{{rotate_deg: [0, 1, 0, 90]}}, "
        "{{translate: [{}, 2, 3]}}]}}\n"
        "lights: [{{type: point, position: [{}, 5, 0], intensity: 1}}]\n",
        x(0.123456), x(0.0625), x(0.015625), x(-0.25), x(0.2)));
}

TEST(SceneOrigin, OrdinaryScenesStayWhereTheyAre) {
    EXPECT_EQ(moved_scene(0).origin, DVec3(0));
    EXPECT_EQ(moved_scene(400).origin, DVec3(0));
}

// At 1e6 mm a float resolves 0.06 mm; relative to the scene's origin nothing is lost: 2^-14 mm
// here.
TEST(SceneOrigin, FarScenesKeepTheirPrecision) {
    const Scene near = moved_scene(0), far = moved_scene(1e6);
    const double shift = 1e6 - far.origin.x;
    EXPECT_LT(std::abs(shift), 513);
    const auto expect_shifted = [&](Vec3 here, Vec3 there) {
        EXPECT_NEAR(there.x, double(here.x) + shift, 1e-4);
        EXPECT_EQ(there.y, here.y);
        EXPECT_EQ(there.z, here.z);
    };
    expect_shifted(near.cameras[0].position, far.cameras[0].position);
    expect_shifted(near.cameras[0].look_at, far.cameras[0].look_at);
    expect_shifted(near.objects[0].transform.translation, far.objects[0].transform.translation);
    expect_shifted(near.objects[1].transform.translation, far.objects[1].transform.translation);
    expect_shifted(std::get<PointLight>(near.lights[0].shape).position,
                   std::get<PointLight>(far.lights[0].shape).position);
}

}  // namespace
}  // namespace tallow
