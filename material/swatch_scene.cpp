// SPDX-License-Identifier: Apache-2.0
#include "material/swatch_scene.h"

namespace tallow {
namespace {

constexpr std::uint32_t kMaterial = 0, kFloor = 1, kFin = 2;  // indices of Scene::materials

Object place(Shape shape, Vec3 center, std::uint32_t material) {
    Affine to_world;
    to_world.translation = center;
    return {std::move(shape), material, to_world, "swatch"};
}

QuadLight square_light(Vec3 center, Vec3 target, float edge, Rgb radiance) {
    const Frame frame = make_frame(glm::normalize(target - center));
    return {center, edge * frame.s, edge * frame.t, frame.n, radiance};
}

}  // namespace

Scene swatch_scene(const SubsurfaceMaterial& material) {
    Scene scene;
    scene.cameras = {{"swatch",
                      {0, 38, 76},
                      {0, 9.6f, 0},
                      {0, 1, 0},
                      glm::radians(18.5f),
                      kSwatchWidth,
                      kSwatchHeight}};
    scene.materials = {{"material", material},
                       {"floor", DiffuseMaterial{Rgb(0.08f)}},
                       {"fin", DiffuseMaterial{Rgb(0.02f)}}};
    scene.objects = {place(CubeShape{{12, 10, 10}}, {0, 5, 0}, kMaterial),
                     place(SphereShape{5.5f}, {0, 15.5f, 0}, kMaterial),
                     place(PlaneShape{{0, 1, 0}, kInfinity}, {0, 0, 0}, kFloor),
                     place(CubeShape{{0.25f, 9, 6}}, {0, 4.5f, 8.1f}, kFin)};
    scene.lights = {
        {square_light({-60, 22, 24}, {0, 6, 5}, 6, Rgb(520))},
        {square_light({18, 46, -50}, {0, 13, 0}, 26, Rgb(40))},
        {EnvironmentLight{Rgb(0.05f)}},
    };
    scene.groups = {{"default", Rgb(1)}};
    scene.settings.samples = 4;
    scene.settings.light_samples = 16;
    scene.settings.tolerance = 0.02f;
    return scene;
}

}  // namespace tallow
