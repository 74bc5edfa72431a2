// SPDX-License-Identifier: Apache-2.0
// What the reference refuses, and how it says so.
#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "experiments/reference/bodies.h"
#include "experiments/reference/lamps.h"
#include "tests/support/ball_mesh.h"
#include "tests/support/error_text.h"
#include "tests/support/scene_text.h"

namespace tallow::reference {
namespace {

const std::string kStone = "materials:\n  stone: {type: subsurface, preset: marble}\n";

std::string refusal(const std::string& text) {
    return error_text<InputError>([&] {
        const Scene scene = scene_of(kCamera + text);
        Stats stats;
        const SceneGeometry geometry = load_geometry(scene, stats);
        const Bodies bodies(scene, geometry, scene.cameras[0], {.cells = 1000});
        const Lamps lamps(scene, bodies.center(), bodies.radius());
    });
}

TEST(ReferenceErrors, NameTheOpaqueObject) {
    EXPECT_EQ(refusal("materials: {floor: {type: diffuse, reflectance: 0.5}}\n"
                      "objects:\n  - {shape: cube, size: 1, material: floor}\n"),
              "folder/scene.yaml:4:5: objects[0]: expected a subsurface material, got the opaque "
              "'floor': the reference knows translucent bodies only");
}

TEST(ReferenceErrors, ShapesThatItCannotFollow) {
    EXPECT_EQ(refusal(kStone + "objects:\n  - {shape: sphere, radius: 2, material: stone, "
                               "transform: [{scale: [1, 2, 1]}]}\n"),
              "folder/scene.yaml:5:5: objects[0]: transform: expected a round sphere, got an "
              "ellipsoid");
    EXPECT_EQ(refusal(kStone + "objects:\n  - {shape: plane, point: [0, 0, 0], normal: [0, 1, 0], "
                               "radius: 3, material: stone}\n"),
              "folder/scene.yaml:5:5: objects[0]: shape: expected sphere, cube or mesh");
}

TEST(ReferenceErrors, TintedSurface) {
    EXPECT_EQ(refusal("materials: {stone: {type: subsurface, preset: marble, albedo: 0.5}}\n"
                      "objects:\n  - {shape: cube, size: 1, material: stone}\n"),
              "folder/scene.yaml:4:5: objects[0]: expected a material without albedo, got a tinted "
              "surface");
}

TEST(ReferenceErrors, SmoothNormals) {
    Scene scene =
        scene_of(kCamera + kStone + "objects:\n  - {shape: cube, size: 1, material: stone}\n");
    SceneGeometry geometry;
    geometry.surfaces.emplace_back(test::sphere_mesh(1, 1));
    EXPECT_EQ(
        error_text<InputError>([&] { Bodies(scene, geometry, scene.cameras[0], {.cells = 1000}); }),
        "folder/scene.yaml:5:5: objects[0]: normals: expected flat, got smooth ones");
}

TEST(ReferenceErrors, CameraInside) {
    for (const char* shape : {"sphere, radius: 20", "cube, size: 30"})
        EXPECT_EQ(refusal(kStone + "objects:\n  - {shape: " + shape + ", material: stone}\n"),
                  "folder/scene.yaml:5:5: objects[0]: expected the camera outside, got it inside");
}

TEST(ReferenceErrors, LightWithoutArea) {
    EXPECT_EQ(
        refusal(kStone + "objects:\n  - {shape: sphere, radius: 2, material: stone}\n"
                         "lights:\n  - {type: environment, radiance: 1}\n"
                         "  - {type: point, position: [0, 9, 0], intensity: 1}\n"),
        "folder/scene.yaml: lights[1]: expected a light with an area or an environment, got a "
        "point, spot or directional one, which no path over a mirror reflection can end at");
}

TEST(ReferenceErrors, NoBody) {
    EXPECT_EQ(refusal("lights: []\n"),
              "folder/scene.yaml: objects: expected a translucent body, got none");
}

}  // namespace
}  // namespace tallow::reference
