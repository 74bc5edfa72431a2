// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_yaml.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/scene_text.h"

namespace tallow {
namespace {

void expect_near(Vec3 got, Vec3 expected, float tolerance = 1e-5f) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(got[i], expected[i], tolerance) << "component " << i;
}

template <class T>
const T& shape_of(const Scene& scene, std::size_t object) {
    return std::get<T>(scene.objects.at(object).shape);
}

template <class T>
const T& light_of(const Scene& scene, std::size_t light) {
    return std::get<T>(scene.lights.at(light).shape);
}

template <class T>
const T& material_of(const Scene& scene, std::size_t material) {
    return std::get<T>(scene.materials.at(material).kind);
}

TEST(SceneYaml, ReadsCamerasInMillimetresAndRadians) {
    const Scene scene = scene_of(kFullScene);
    EXPECT_EQ(scene.mm_per_unit, 10);
    ASSERT_EQ(scene.cameras.size(), 2u);
    const Camera& main = scene.cameras[0];
    EXPECT_EQ(main.name, "main");
    EXPECT_EQ(main.position, Vec3(0, 280, 1100));
    EXPECT_EQ(main.look_at, Vec3(0, 190, 0));
    EXPECT_EQ(main.up, Vec3(0, 1, 0));
    EXPECT_FLOAT_EQ(main.fov, kPi / 3);
    EXPECT_EQ(main.width, 640);
    EXPECT_EQ(main.height, 480);
    EXPECT_EQ(scene.cameras[1].name, "top");
    EXPECT_EQ(scene.cameras[1].up, Vec3(0, 0, -1));
}

// Apertures and distances of focus say mm; points are in the unit of the scene.
TEST(SceneYaml, ReadsLenses) {
    const std::string lens =
        "{type: thin-lens, position: [0, 0, 30], look_at: [0, 0, 0], fov_deg: "
        "40, resolution: [4, 3], aperture_mm: 5, ";
    const Scene scene = scene_of("unit: cm\ncameras: {a: " + lens + "focus_mm: 120}, b: " + lens +
                                 "focus_at: [7, -3, 10]}}\n");
    EXPECT_EQ(scene.cameras[0].lens_radius, 2.5f);
    EXPECT_EQ(scene.cameras[0].focus, 120);
    EXPECT_FALSE(scene.cameras[0].focus_point);
    EXPECT_EQ(scene.cameras[1].focus, 200);
    EXPECT_EQ(scene.cameras[1].focus_point, Vec3(70, -30, 100));
}

// What a keyframe leaves out is as the camera says; the camera itself is as in frame 0.
TEST(SceneYaml, ReadsMotion) {
    const std::string rest = "fov_deg: 90, resolution: [4, 3]";
    const Scene scene = scene_of(
        "unit: cm\ncameras:\n  turn: {type: perspective, position: [0, 0, 3], look_at: [0, 0, 0], "
        "turntable: {frames: 12, axis: [0, 0, 2], degrees: 180}, " +
        rest +
        "}\n  full: {type: perspective, position: [0, 0, 3], look_at: [0, 0, 0], turntable: "
        "{frames: 7}, " +
        rest +
        "}\n  way: {type: perspective, look_at: [0, 1, 0], keyframes: [{frame: 2, position: [0, 1, "
        "3]}, {frame: 5, position: [1, 1, 3], look_at: [1, 1, 0], fov_deg: 60}], " +
        rest + "}\n");
    const auto& turn = std::get<Turntable>(scene.cameras[0].motion);
    EXPECT_EQ(turn.frames, 12);
    EXPECT_EQ(turn.axis, Vec3(0, 0, 1));
    EXPECT_FLOAT_EQ(turn.angle, kPi);
    EXPECT_EQ(scene.cameras[0].position, Vec3(0, 0, 30));
    const auto& full = std::get<Turntable>(scene.cameras[1].motion);
    EXPECT_EQ(full.axis, Vec3(0, 1, 0));
    EXPECT_FLOAT_EQ(full.angle, kTwoPi);
    const auto& keys = std::get<std::vector<Keyframe>>(scene.cameras[2].motion);
    ASSERT_EQ(keys.size(), 2u);
    EXPECT_EQ(keys[0].frame, 2);
    EXPECT_EQ(keys[0].look_at, Vec3(0, 10, 0));
    EXPECT_FLOAT_EQ(keys[0].fov, kPi / 2);
    EXPECT_EQ(keys[1].look_at, Vec3(10, 10, 0));
    EXPECT_FLOAT_EQ(keys[1].fov, kPi / 3);
    EXPECT_EQ(scene.cameras[2].position, Vec3(0, 10, 30));
    EXPECT_FLOAT_EQ(scene.cameras[2].fov, kPi / 2);
}

// Coefficients are per mm whatever the unit of the scene.
TEST(SceneYaml, ReadsMaterials) {
    const Scene scene = scene_of(kFullScene);
    ASSERT_EQ(scene.materials.size(), 7u);
    const auto& body = material_of<SubsurfaceMaterial>(scene, 0);
    EXPECT_EQ(scene.materials[0].name, "body");
    EXPECT_EQ(body.medium.sigma_s_prime, Rgb(2.19f, 2.62f, 3.0f));
    EXPECT_EQ(body.medium.eta, 1.5f);
    EXPECT_EQ(body.exit, Exit::classic);
    EXPECT_EQ(body.single_scattering, Switch::on);
    EXPECT_EQ(body.connection, Connection::exact);
    EXPECT_EQ(body.transmission, Switch::automatic);
    const auto& candle = material_of<SubsurfaceMaterial>(scene, 1);
    EXPECT_EQ(candle.medium.sigma_a, Rgb(0.002f, 0.006f, 0.03f));
    EXPECT_EQ(candle.medium.sigma_s_prime, Rgb(1.9f, 1.6f, 1.1f));
    EXPECT_EQ(candle.medium.g, 0);
    EXPECT_EQ(candle.medium.eta, 1.43f);
    EXPECT_EQ(candle.model, Model::body_aware);
    EXPECT_EQ(candle.exit, Exit::directional);
    EXPECT_EQ(candle.single_scattering, Switch::automatic);
    const auto& forward = material_of<SubsurfaceMaterial>(scene, 2);
    EXPECT_EQ(forward.medium.sigma_s_prime, Rgb(2.5f));
    EXPECT_EQ(forward.medium.sigma_a, Rgb(0.5f));
    EXPECT_EQ(forward.medium.g, 0.75f);
    EXPECT_EQ(material_of<DiffuseMaterial>(scene, 3).reflectance.value, Rgb(0.5f, 0.25f, 0));
    EXPECT_EQ(material_of<PlasticMaterial>(scene, 4).eta, 1.5f);
    EXPECT_EQ(material_of<PlasticMaterial>(scene, 5).eta, 1.75f);
    EXPECT_EQ(material_of<MirrorMaterial>(scene, 6).reflectance, Rgb(1));
}

TEST(SceneYaml, BodyAwareModelSwitchesItsLayersOnAndTheyCanBeSwitchedOff) {
    const Scene scene = scene_of(R"(
cameras: {main: {type: perspective, position: [0, 0, 9], look_at: [0, 0, 0], fov_deg: 30, resolution: [8, 8]}}
materials:
  plain: {type: subsurface, preset: marble, model: transport}
  aware: {type: subsurface, preset: marble, model: body-aware}
  partly: {type: subsurface, preset: marble, model: body-aware, shifts: off, exit: normalized, re_entry: off}
  other: {type: subsurface, preset: marble, model: dipole, boundary_elements: on}
)");
    const auto body = [&](std::size_t i) { return material_of<SubsurfaceMaterial>(scene, i); };
    EXPECT_FALSE(body(0).shifts);
    EXPECT_FALSE(body(0).boundary_elements);
    EXPECT_TRUE(body(1).shifts);
    EXPECT_TRUE(body(1).boundary_elements);
    EXPECT_EQ(body(1).exit, Exit::directional);
    EXPECT_FALSE(body(2).shifts);
    EXPECT_TRUE(body(2).boundary_elements);
    EXPECT_EQ(body(2).exit, Exit::normalized);
    EXPECT_TRUE(body(1).re_entry);
    EXPECT_FALSE(body(2).re_entry);
    EXPECT_FALSE(body(3).shifts);
    EXPECT_TRUE(body(3).boundary_elements);
}

TEST(SceneYaml, PresetKeepsItsCoefficientsUnderAnotherIndexAndPhase) {
    const Scene scene = scene_of(
        kCamera + "materials: {a: {type: subsurface, preset: skimmilk, eta: 1.4, g: 0.9}}\n");
    const Medium& medium = material_of<SubsurfaceMaterial>(scene, 0).medium;
    EXPECT_EQ(medium.sigma_s_prime, Rgb(0.7f, 1.22f, 1.9f));
    EXPECT_EQ(medium.eta, 1.4f);
    EXPECT_EQ(medium.g, 0.9f);
}

TEST(SceneYaml, SingleScatteringNamesItsConnection) {
    const auto material = [](const std::string& value) {
        return material_of<SubsurfaceMaterial>(
            scene_of(kCamera +
                     "materials: {a: {type: subsurface, preset: marble, single_scattering: " +
                     value + "}}\n"),
            0);
    };
    EXPECT_EQ(material("exact").connection, Connection::exact);
    EXPECT_EQ(material("exact").single_scattering, Switch::on);
    EXPECT_EQ(material("straight").connection, Connection::straight);
    EXPECT_EQ(material("on").connection, Connection::exact);
    EXPECT_EQ(material("off").single_scattering, Switch::off);
}

TEST(SceneYaml, ReadsShapes) {
    const Scene scene = scene_of(kFullScene);
    ASSERT_EQ(scene.objects.size(), 8u);
    const auto& bunny = shape_of<MeshShape>(scene, 0);
    EXPECT_EQ(bunny.file, scene.file.parent_path() / "meshes/bunny.ply");
    EXPECT_EQ(bunny.normals, Normals::flat);
    EXPECT_EQ(scene.objects[0].material, 0u);
    EXPECT_EQ(scene.objects[0].where, scene.file.string() + ":14:5");
    EXPECT_EQ(scene.objects[1].transform.translation, Vec3(0, 50, 0));
    EXPECT_EQ(shape_of<SphereShape>(scene, 1).radius, 5);
    EXPECT_EQ(scene.objects[1].material, 1u);
    EXPECT_EQ(scene.objects[2].transform.translation, Vec3(0));
    EXPECT_EQ(shape_of<CubeShape>(scene, 2).size, Vec3(30));
    EXPECT_EQ(scene.objects[3].transform.translation, Vec3(150, 50, 0));
    EXPECT_EQ(shape_of<CubeShape>(scene, 3).size, Vec3(10, 20, 30));
    EXPECT_EQ(shape_of<PlaneShape>(scene, 4).normal, Vec3(0, 1, 0));
    EXPECT_EQ(shape_of<PlaneShape>(scene, 4).radius, kInfinity);
    EXPECT_EQ(scene.objects[5].transform.translation, Vec3(0, -10, 0));
    EXPECT_EQ(shape_of<PlaneShape>(scene, 5).radius, 400);
    EXPECT_EQ(shape_of<DiscShape>(scene, 6).normal, Vec3(0, 0, -1));
    EXPECT_EQ(shape_of<DiscShape>(scene, 6).radius, 10);
    EXPECT_EQ(shape_of<MeshShape>(scene, 7).file, "/data/lamp.obj");
    EXPECT_EQ(shape_of<MeshShape>(scene, 7).normals, Normals::automatic);
}

TEST(SceneYaml, ReadsLights) {
    const Scene scene = scene_of(kFullScene);
    ASSERT_EQ(scene.lights.size(), 7u);
    const auto& quad = light_of<QuadLight>(scene, 0);
    EXPECT_EQ(quad.center, Vec3(0, 100, 0));
    expect_near(quad.normal, Vec3(0, 0, -1));
    expect_near(quad.u, Vec3(40, 0, 0));
    expect_near(quad.v, Vec3(0, 20, 0));
    EXPECT_EQ(quad.radiance, Rgb(20, 10, 5));
    EXPECT_EQ(light_of<PointLight>(scene, 1).position, Vec3(0, 500, 0));
    EXPECT_EQ(light_of<PointLight>(scene, 1).intensity, Rgb(100));
    EXPECT_EQ(light_of<DirectionalLight>(scene, 2).direction, Vec3(0, -1, 0));
    EXPECT_EQ(light_of<DirectionalLight>(scene, 2).irradiance, Rgb(1, 2, 3));
    const auto& spot = light_of<SpotLight>(scene, 3);
    EXPECT_EQ(spot.position, Vec3(0, 90, 0));
    EXPECT_EQ(spot.direction, Vec3(0, -1, 0));
    EXPECT_FLOAT_EQ(spot.cos_inner, std::cos(kPi / 18));
    EXPECT_FLOAT_EQ(spot.cos_outer, std::cos(kPi / 6));
    EXPECT_EQ(light_of<SpotLight>(scene, 4).direction, Vec3(1, 0, 0));
    EXPECT_FLOAT_EQ(light_of<SpotLight>(scene, 4).cos_inner, std::cos(kPi / 5));  // 0.8 * 45 deg
    EXPECT_EQ(light_of<SphereLight>(scene, 5).radius, 2.5f);
    EXPECT_EQ(light_of<EnvironmentLight>(scene, 6).radiance, Rgb(1, 1, 2));
}

TEST(SceneYaml, GroupsAreNumberedByFirstAppearance) {
    const Scene scene = scene_of(kFullScene);
    ASSERT_EQ(scene.groups.size(), 3u);
    EXPECT_EQ(scene.groups[0].name, "key");
    EXPECT_EQ(scene.groups[0].scale, Rgb(0.5f));
    EXPECT_EQ(scene.groups[1].name, "default");
    EXPECT_EQ(scene.groups[1].scale, Rgb(1));
    EXPECT_EQ(scene.groups[2].name, "fill");
    EXPECT_EQ(scene.groups[2].scale, Rgb(1, 2, 3));
    const std::vector<std::uint32_t> expected = {0, 1, 0, 2, 1, 1, 2};
    for (std::size_t i = 0; i < expected.size(); ++i)
        EXPECT_EQ(scene.lights[i].group, expected[i]) << "light " << i;
}

TEST(SceneYaml, ReadsSettings) {
    const Settings settings = scene_of(kFullScene).settings;
    EXPECT_EQ(settings.tolerance, 0.02f);
    EXPECT_EQ(settings.samples, 4);
    EXPECT_EQ(settings.light_samples, 32);
    EXPECT_EQ(settings.single_scattering_depths, std::nullopt);
    EXPECT_EQ(scene_of(kCamera, {"settings.single_scattering_depths=64"})
                  .settings.single_scattering_depths,
              64);
    EXPECT_EQ(scene_of(kCamera, {"settings.single_scattering_depths=auto"})
                  .settings.single_scattering_depths,
              std::nullopt);
    EXPECT_EQ(scene_of(kCamera + "settings: {light_samples: auto}\n").settings.light_samples,
              std::nullopt);
}

// Only cameras are required; empty sections are a black picture, not an error.
TEST(SceneYaml, TreatsAbsentSectionsAsEmpty) {
    for (const char* rest : {"", "objects: []\nlights: []\n", "materials: {}\ngroups: {}\n"}) {
        const Scene scene = scene_of(kCamera + rest);
        EXPECT_EQ(scene.mm_per_unit, 1);
        EXPECT_EQ(scene.cameras.size(), 1u);
        EXPECT_TRUE(scene.materials.empty() && scene.objects.empty() && scene.lights.empty());
        EXPECT_EQ(scene.settings.samples, Settings().samples);
    }
}

TEST(SceneYaml, ReadsJsonAndAliasesAndSigns) {
    const Scene json = scene_of(
        "{\"unit\": \"m\",\n\t\"cameras\": {\"main\": {\"type\": \"perspective\",\n"
        "\t\t\"position\": [0, 0, 1e1], \"look_at\": [0, -0.5, 0],\n"
        "\t\t\"fov_deg\": 40, \"resolution\": [4, 3]}},\n\t\"objects\": []}\n");
    EXPECT_EQ(json.cameras[0].position, Vec3(0, 0, 10000));
    const Scene aliased = scene_of(kCamera +
                                   "materials:\n  a: &grey {type: diffuse, reflectance: +0.5}\n"
                                   "  b: *grey\n");
    EXPECT_EQ(material_of<DiffuseMaterial>(aliased, 1).reflectance.value, Rgb(0.5f));
}

Affine transform_of(const std::string& steps) {
    return scene_of("unit: cm\n" + kCamera +
                    "materials: {m: {type: mirror}}\nobjects: [{shape: sphere, radius: 1, "
                    "material: m, transform: " +
                    steps + "}]\n")
        .objects[0]
        .transform;
}

TEST(SceneTransform, AppliesStepsInTheirOrder) {
    expect_near(transform_of("[{translate: [1, 0, 0]}, {scale: 3}]").point(Vec3(0)), {30, 0, 0});
    expect_near(transform_of("[{scale: 3}, {translate: [1, 0, 0]}]").point(Vec3(0)), {10, 0, 0});
    expect_near(transform_of("[]").point(Vec3(1, 2, 3)), {1, 2, 3});
    expect_near(transform_of("[{scale: [1, -2, 3]}]").point(Vec3(1)), {1, -2, 3});
}

// The translation of 1 cm is 10 mm; a quarter turn about y takes z to x.
TEST(SceneTransform, TurnsByTheRightHandRule) {
    const Affine turned =
        transform_of("[{scale: 2}, {rotate_deg: [0, 5, 0, 90]}, {translate: [1, 0, 0]}]");
    expect_near(turned.point(Vec3(0, 0, 1)), {12, 0, 0});
    expect_near(turned.vector(Vec3(1, 0, 0)), {0, 0, -2});
}

TEST(SceneOverride, ReplacesAndAddsValues) {
    const Scene scene =
        scene_of(kFullScene, {"materials.candle.sigma_a=[1, 2, 3]", "materials.candle.g=0.5",
                              "lights.1.intensity=7", "groups.default.scale=4", "unit=mm",
                              "objects.1.transform=[{scale: 2}]", "materials.floor={type: mirror}",
                              "cameras.main.resolution.1=99"});
    EXPECT_EQ(material_of<SubsurfaceMaterial>(scene, 1).medium.sigma_a, Rgb(1, 2, 3));
    EXPECT_EQ(material_of<SubsurfaceMaterial>(scene, 1).medium.g, 0.5f);
    EXPECT_EQ(light_of<PointLight>(scene, 1).intensity, Rgb(7));
    EXPECT_EQ(scene.groups[1].scale, Rgb(4));
    EXPECT_EQ(scene.cameras[0].position, Vec3(0, 28, 110));
    EXPECT_EQ(scene.objects[1].transform.vector(Vec3(1)), Vec3(2));
    EXPECT_EQ(material_of<MirrorMaterial>(scene, 3).reflectance, Rgb(1));
    EXPECT_EQ(scene.cameras[0].height, 99);
}

TEST(SceneOverride, SetsGroupsAndSettingsThatTheFileLeavesOut) {
    const std::string text = kCamera + "lights: [{type: environment, radiance: 1, group: sky}]\n";
    const Scene scene = scene_of(text, {"groups.sky.scale=0.5", "settings.samples=2"});
    EXPECT_EQ(scene.groups[0].scale, Rgb(0.5f));
    EXPECT_EQ(scene.settings.samples, 2);
}

TEST(SceneOverride, LastOneWins) {
    EXPECT_EQ(scene_of(kCamera, {"settings.samples=2", "settings.samples=3"}).settings.samples, 3);
}

// What a flag changes must not reach the other users of an alias.
TEST(SceneOverride, ChangesOneUserOfAnAlias) {
    const Scene scene = scene_of(kCamera +
                                     "materials:\n  a: &m {type: diffuse, reflectance: 0.5}\n"
                                     "  b: *m\n",
                                 {"materials.b.reflectance=1"});
    EXPECT_EQ(material_of<DiffuseMaterial>(scene, 0).reflectance.value, Rgb(0.5f));
    EXPECT_EQ(material_of<DiffuseMaterial>(scene, 1).reflectance.value, Rgb(1));
}

}  // namespace
}  // namespace tallow
