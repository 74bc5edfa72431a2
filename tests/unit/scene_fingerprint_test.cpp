// SPDX-License-Identifier: Apache-2.0
// A fingerprint changes with what the irradiance at the samples depends on, and with nothing else.
#include "common/cloud/scene_fingerprint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "common/cloud/cache_io.h"

namespace tallow {
namespace {

struct TestScene {
    Scene scene;
    SceneGeometry geometry;
};

/// A wax mesh on a grey plane, a point light in one group and a quad in another.
TestScene test_scene() {
    TestScene test;
    Scene& scene = test.scene;
    scene.cameras = {{"main", {0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 0.6f, 64, 64}};
    SubsurfaceMaterial wax;
    wax.medium = {Rgb(0.01f), Rgb(2), 0, 1.5f};
    scene.materials = {{"wax", wax}, {"floor", DiffuseMaterial{Rgb(0.5f)}}};
    scene.objects = {{MeshShape{"bunny.ply", Normals::flat}, 0, {}, "scene.yaml:3:5"},
                     {PlaneShape{{0, 1, 0}, kInfinity}, 1, {}, "scene.yaml:4:5"}};
    scene.lights = {{PointLight{{0, 50, 0}, Rgb(100)}, 0},
                    {QuadLight{{0, 90, 0}, {10, 0, 0}, {0, 0, 10}, {0, -1, 0}, Rgb(20)}, 1}};
    scene.groups = {{"key", Rgb(1)}, {"fill", Rgb(1)}};
    scene.settings.bounces = 0;
    test.geometry.mesh_hash = {0x9f86d081884c7d65, 0};
    return test;
}

Fingerprint fingerprint_after(const std::function<void(TestScene&)>& change) {
    TestScene test = test_scene();
    change(test);
    return scene_fingerprint(test.scene, test.geometry);
}

/// Keys of the pairs that differ after `change`.
std::vector<std::string> changed_keys(const std::function<void(TestScene&)>& change) {
    const Fingerprint before = fingerprint_after([](TestScene&) {});
    const Fingerprint after = fingerprint_after(change);
    std::vector<std::string> keys;
    for (const auto& pair : after)
        if (std::find(before.begin(), before.end(), pair) == before.end())
            keys.push_back(pair.first);
    return keys;
}

using Keys = std::vector<std::string>;

TEST(SceneFingerprint, IsReadable) {
    const Fingerprint expected{
        {"objects", "2"},
        {"lights", "2"},
        {"groups", "2"},
        {"origin_mm", "0 0 0"},
        {"objects[0].shape", "mesh"},
        {"objects[0].mesh", "xxh3:9f86d081884c7d65"},
        {"objects[0].mm_per_unit", "1"},
        {"objects[0].normals", "flat"},
        {"objects[0].transform", "1 0 0 0 0 1 0 0 0 0 1 0"},
        {"objects[0].translucent", "yes"},
        {"objects[0].eta", "1.5"},
        {"objects[1].shape", "plane"},
        {"objects[1].normal", "0 1 0"},
        {"objects[1].radius", "inf"},
        {"objects[1].transform", "1 0 0 0 0 1 0 0 0 0 1 0"},
        {"objects[1].translucent", "no"},
        {"lights[0].type", "point"},
        {"lights[0].position", "0 50 0"},
        {"lights[0].intensity", "100 100 100"},
        {"lights[0].group", "key"},
        {"lights[1].type", "quad"},
        {"lights[1].center", "0 90 0"},
        {"lights[1].u", "10 0 0"},
        {"lights[1].v", "0 0 10"},
        {"lights[1].normal", "0 -1 0"},
        {"lights[1].radiance", "20 20 20"},
        {"lights[1].group", "fill"},
        {"groups[0].name", "key"},
        {"groups[1].name", "fill"},
        {"indirect.bounces", "0"},
        {"sampling.light_samples", "auto"},
    };
    EXPECT_EQ(fingerprint_after([](TestScene&) {}), expected);
}

TEST(SceneFingerprint, IgnoresWhatPassOneDoesNotUse) {
    EXPECT_EQ(changed_keys([](TestScene& t) {
                  Scene& scene = t.scene;
                  scene.cameras[0].position.x = 7;
                  scene.cameras.push_back(scene.cameras[0]);
                  scene.groups[0].scale = Rgb(3);
                  scene.settings.tolerance = 0.5f;
                  scene.settings.samples = 1;
                  scene.file = "elsewhere.yaml";
                  scene.objects[0].where = "elsewhere.yaml:1:1";
                  scene.materials[0].name = "paraffin";
                  scene.materials[1].kind = MirrorMaterial{Rgb(0.9f)};
                  std::get<MeshShape>(scene.objects[0].shape).file = "copy.ply";
                  auto& wax = std::get<SubsurfaceMaterial>(scene.materials[0].kind);
                  wax.medium.sigma_a = Rgb(1);
                  wax.medium.sigma_s_prime = Rgb(7);
                  wax.medium.g = 0.9f;
                  wax.exit = Exit::classic;
                  wax.single_scattering = Switch::off;
              }),
              Keys{});
}

// What indirect light depends on, and only where there is any.
TEST(SceneFingerprint, SeesWhatReflectsIndirectLight) {
    const auto keys = [](const std::function<void(Scene&)>& change) {
        TestScene before = test_scene();
        before.scene.settings.bounces = 3;
        TestScene after = before;
        change(after.scene);
        const Fingerprint a = scene_fingerprint(before.scene, before.geometry);
        const Fingerprint b = scene_fingerprint(after.scene, after.geometry);
        Keys differing;
        for (const auto& pair : b)
            if (std::find(a.begin(), a.end(), pair) == a.end()) differing.push_back(pair.first);
        return differing;
    };
    EXPECT_EQ(keys([](Scene& s) { s.settings.bounces = 2; }), Keys{"indirect.bounces"});
    EXPECT_EQ(keys([](Scene& s) {
                  std::get<SubsurfaceMaterial>(s.materials[0].kind).medium.sigma_a = Rgb(1);
              }),
              Keys{"indirect.objects[0].sigma_a"});
    EXPECT_EQ(keys([](Scene& s) {
                  std::get<SubsurfaceMaterial>(s.materials[0].kind).model = Model::dipole;
              }),
              Keys{"indirect.objects[0].model"});
    EXPECT_EQ(keys([](Scene& s) { s.materials[1].kind = DiffuseMaterial{Rgb(0.25f)}; }),
              Keys{"indirect.objects[1].reflectance"});
    EXPECT_EQ(keys([](Scene& s) { s.materials[1].kind = MirrorMaterial{Rgb(0.5f)}; }),
              Keys{"indirect.objects[1].type"});
}

TEST(SceneFingerprint, ZeroHasNoSign) {
    EXPECT_EQ(
        changed_keys([](TestScene& t) { t.scene.objects[0].transform.translation.x = -0.0f; }),
        Keys{});
}

TEST(SceneFingerprint, SeesObjects) {
    EXPECT_EQ(changed_keys([](TestScene& t) { t.geometry.mesh_hash[0] ^= 1; }),
              Keys{"objects[0].mesh"});
    EXPECT_EQ(changed_keys([](TestScene& t) { t.scene.mm_per_unit = 10; }),
              Keys{"objects[0].mm_per_unit"});
    EXPECT_EQ(changed_keys([](TestScene& t) {
                  std::get<MeshShape>(t.scene.objects[0].shape).normals = Normals::smooth;
              }),
              Keys{"objects[0].normals"});
    EXPECT_EQ(changed_keys([](TestScene& t) {
                  std::get<SubsurfaceMaterial>(t.scene.materials[0].kind).medium.eta = 1.3f;
              }),
              Keys{"objects[0].eta"});
    EXPECT_EQ(changed_keys([](TestScene& t) { t.scene.objects[1].material = 0; }),
              (Keys{"objects[1].translucent", "objects[1].eta"}));
    EXPECT_EQ(changed_keys([](TestScene& t) { t.scene.objects[0].shape = SphereShape{0.1f}; }),
              (Keys{"objects[0].shape", "objects[0].radius"}));
}

TEST(SceneFingerprint, SeesEveryNumberOfATransform) {
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            EXPECT_EQ(changed_keys([&](TestScene& t) {
                          float& x = t.scene.objects[1].transform.linear[column][row];
                          x = std::nextafter(x, 2.0f);
                      }),
                      Keys{"objects[1].transform"});
        EXPECT_EQ(changed_keys([&](TestScene& t) {
                      t.scene.objects[1].transform.translation[row] = 1e-20f;
                  }),
                  Keys{"objects[1].transform"});
    }
}

TEST(SceneFingerprint, SeesLights) {
    EXPECT_EQ(changed_keys([](TestScene& t) {
                  std::get<PointLight>(t.scene.lights[0].shape).position.y = 51;
              }),
              Keys{"lights[0].position"});
    EXPECT_EQ(changed_keys([](TestScene& t) {
                  std::get<QuadLight>(t.scene.lights[1].shape).radiance.b = 21;
              }),
              Keys{"lights[1].radiance"});
    EXPECT_EQ(changed_keys([](TestScene& t) { t.scene.lights[1].group = 0; }),
              Keys{"lights[1].group"});
    EXPECT_EQ(changed_keys([](TestScene& t) { t.scene.groups[1].name = "rim"; }),
              (Keys{"lights[1].group", "groups[1].name"}));
    EXPECT_EQ(changed_keys([](TestScene& t) {
                  t.scene.lights.push_back({EnvironmentLight{Rgb(1)}, 0});
              }),
              (Keys{"lights", "lights[2].type", "lights[2].radiance", "lights[2].group"}));
}

SubsurfaceMaterial& wax(TestScene& t) {
    return std::get<SubsurfaceMaterial>(t.scene.materials[0].kind);
}

/// The value of one pair when the wax has this texture.
std::string pair_with(const Texture& texture, const std::string& key) {
    for (const auto& [k, value] : fingerprint_after(
             [&](TestScene& t) { wax(t).albedo.texture = std::make_shared<Texture>(texture); }))
        if (k == "objects[0]." + key) return value;
    return "";
}

TEST(SceneFingerprint, SeesTheAlbedoOfTranslucentBodies) {
    EXPECT_EQ(changed_keys([](TestScene& t) { wax(t).albedo = Rgb(1, 0.5f, 1); }),
              Keys{"objects[0].albedo"});
    Texture checker{CheckerTexture{Rgb(1), Rgb(0.5f)}, Texture::Coordinates::object, {3, 4, 5}};
    EXPECT_EQ(changed_keys([&](TestScene& t) {
                  wax(t).albedo.texture = std::make_shared<Texture>(checker);
              }),
              (Keys{"objects[0].albedo", "objects[0].albedo.even", "objects[0].albedo.odd",
                    "objects[0].albedo.coordinates", "objects[0].albedo.period"}));
    EXPECT_EQ(pair_with(checker, "albedo.odd"), "0.5 0.5 0.5");
    EXPECT_EQ(pair_with(checker, "albedo.coordinates"), "object");
    EXPECT_EQ(pair_with(checker, "albedo.period"), "3 4 5");
    // Opaque surfaces are for pass two alone.
    EXPECT_EQ(changed_keys([&](TestScene& t) {
                  auto& floor = std::get<DiffuseMaterial>(t.scene.materials[1].kind);
                  floor.reflectance.texture = std::make_shared<Texture>(checker);
              }),
              Keys{});
}

TEST(SceneFingerprint, SeesThePixelsOfAnAlbedo) {
    RgbImage pixels{2, 1, {Rgb(0.25f), Rgb(0.5f)}};
    const auto image = [&] {
        return pair_with({ImageTexture{std::make_shared<RgbImage>(pixels)}}, "albedo.image");
    };
    const std::string before = image();
    EXPECT_TRUE(before.starts_with("2 x 1 xxh3:")) << before;
    EXPECT_EQ(image(), before);
    pixels.pixels[1].b = 0.75f;
    EXPECT_NE(image(), before);
    EXPECT_NE(image().substr(6), before.substr(6));
    pixels.pixels[1].b = 0.5f;
    std::swap(pixels.width, pixels.height);
    EXPECT_NE(image(), before);
}

TEST(SceneFingerprint, LightSamplesAreRecordedAndNotCompared) {
    const auto change = [](TestScene& t) { t.scene.settings.light_samples = 64; };
    EXPECT_EQ(changed_keys(change), Keys{"sampling.light_samples"});
    EXPECT_NO_THROW(require_fingerprint("x.tallow", fingerprint_after([](TestScene&) {}),
                                        fingerprint_after(change)));
}

}  // namespace
}  // namespace tallow
