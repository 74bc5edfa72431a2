// SPDX-License-Identifier: Apache-2.0
// Lights of the scene file that read files: what they become, and every refusal with its exact
// message.
#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "common/cloud/scene_fingerprint.h"
#include "common/image/exr_io.h"
#include "tests/support/error_text.h"
#include "tests/support/scene_text.h"
#include "tests/support/test_files.h"

namespace tallow {
namespace {

/// A folder with sky.exr (2 x 1: red left, blue right), huge.exr, dark.hdr and two meshes.
class LightFiles : public testing::Test {
protected:
    void SetUp() override {
        folder_ = fresh_folder();
        write_sky("sky.exr", 1);
        write_sky("huge.exr", 1e29f);
        write_bytes(folder_ / "text.exr", "unit: mm\n");
        write_bytes(folder_ / "triangle.off", "OFF\n3 1 0\n0 0 0\n0 0 1\n1 0 0\n3 0 1 2\n");
        write_bytes(folder_ / "quad.off", "OFF\n4 1 0\n0 0 0\n0 0 1\n1 0 1\n1 0 0\n4 0 1 2 3\n");
        write_bytes(folder_ / "broken.off", "OFF\n3 1 0\n0 0 0\n");
    }

    void write_sky(const std::string& name, float scale) {
        Image image = make_image(2, 1);
        image.add_channel("R") = {scale, 0};
        image.add_channel("G") = {0, 0};
        image.add_channel("B") = {0, 2 * scale};
        write_exr(folder_ / name, image);
    }

    Scene scene(const std::string& lights, const std::string& unit = "mm") const {
        return parse_scene(kCamera + "lights: [" + lights + "]\nunit: " + unit + "\n",
                           folder_ / "scene.yaml");
    }

    template <class L>
    L light(const std::string& text, const std::string& unit = "mm") const {
        return std::get<L>(scene(text, unit).lights.at(0).shape);
    }

    /// Without the folder.
    std::string error(const std::string& lights) const {
        std::string text = error_text<InputError>([&] { scene(lights); });
        const std::string prefix = folder_.string() + "/";
        for (std::size_t at; (at = text.find(prefix)) != std::string::npos;)
            text.erase(at, prefix.size());
        return text;
    }

    std::filesystem::path folder_;
};

TEST_F(LightFiles, Environment) {
    const auto sky = light<EnvironmentLight>(
        "{type: environment, file: sky.exr, rotate_deg: 450, scale: [1, 2, 3]}");
    EXPECT_EQ(sky.radiance, Rgb(1, 2, 3));
    EXPECT_FLOAT_EQ(sky.rotation, kPi / 2);
    EXPECT_EQ(sky.image->at({0.25f, 0.5f}).color, Rgb(1, 0, 0));
    EXPECT_EQ(sky.image->at({0.75f, 0.5f}).color, Rgb(0, 0, 2));
    const auto plain = light<EnvironmentLight>("{type: environment, file: sky.exr}");
    EXPECT_EQ(plain.radiance, Rgb(1));
    EXPECT_EQ(plain.rotation, 0);
    EXPECT_EQ(light<EnvironmentLight>("{type: environment, radiance: 3}").image, nullptr);
}

TEST_F(LightFiles, TexturedQuad) {
    const auto quad = light<QuadLight>(
        "{type: quad, position: [0, 0, 0], look_at: [0, 0, 1], size: [2, 1], radiance: 3, "
        "texture: sky.exr}");
    ASSERT_NE(quad.texture, nullptr);
    // Whoever stands before it, looking along -z, has red on the left, which is -x.
    const auto seen = see_light({quad}, {{-0.5f, 0, 9}, {0, 0, -1}});
    EXPECT_EQ(seen->radiance, Rgb(3, 0, 0));
}

TEST_F(LightFiles, Disc) {
    const auto down = light<DiscLight>(
        "{type: disc, position: [1, 2, 3], look_at: [1, 0, 3], radius: 4, radiance: [1, 2, 3]}",
        "cm");
    EXPECT_EQ(down.center, Vec3(10, 20, 30));
    EXPECT_EQ(down.normal, Vec3(0, -1, 0));
    EXPECT_EQ(down.radius, 40);
    EXPECT_EQ(down.radiance, Rgb(1, 2, 3));
    const auto aside = light<DiscLight>(
        "{type: disc, position: [1, 2, 3], direction: [2, 0, 0], radius: 4, radiance: 1}");
    EXPECT_EQ(aside.normal, Vec3(1, 0, 0));
}

TEST_F(LightFiles, Mesh) {
    const auto lamp = light<MeshLight>(
        "{type: mesh, file: triangle.off, radiance: 2, transform: [{scale: 3}, {translate: [0, 5, "
        "0]}]}",
        "cm");
    EXPECT_EQ(lamp.radiance, Rgb(2));
    EXPECT_FLOAT_EQ(lamp.mesh->area(), 450);
    EXPECT_TRUE(lamp.mesh->repair().empty());
    const auto seen = see_light({lamp}, {{10, 60, 10}, {0, -1, 0}});
    ASSERT_TRUE(seen);
    EXPECT_FLOAT_EQ(seen->t, 10);
    const auto cut = light<MeshLight>("{type: mesh, file: quad.off, radiance: 2}");
    EXPECT_EQ(
        cut.mesh->repair().find((folder_ / "quad.off").string() + ": cut 1 polygon into triangles"),
        0u);
}

// A scene far from its file's origin: lights move with the objects.
TEST_F(LightFiles, MeshIsRelativeToTheOrigin) {
    const Scene far = parse_scene(
        kCamera +
            "materials: {m: {type: mirror}}\n"
            "objects: [{shape: sphere, center: [1e6, 0, 0], radius: 1, material: m}]\n"
            "lights: [{type: mesh, file: triangle.off, radiance: 1, transform: [{translate: "
            "[1000000, 3, 0]}, {scale: 1}]}]\n",
        folder_ / "scene.yaml");
    ASSERT_NE(far.origin.x, 0);
    const float x = float(1e6 - far.origin.x);
    EXPECT_TRUE(see_light(far.lights[0], {{x + 0.2f, 9, 0.2f}, {0, -1, 0}}));
}

TEST_F(LightFiles, Errors) {
    const std::string where = "scene.yaml:2:";
    const std::vector<std::pair<std::string, std::string>> rows = {
        {"{type: environment}", "10: missing key 'radiance' or 'file'"},
        {"{type: environment, file: sky.exr, radiance: 1}",
         "30: file: cannot be given together with 'radiance'"},
        {"{type: environment, radiance: 1, rotate_deg: 3}",
         "43: rotate_deg: cannot be given together with 'radiance'"},
        {"{type: environment, radiance: 1, scale: 3}",
         "43: scale: cannot be given together with 'radiance'"},
        {"{type: environment, file: lost.exr}", "36: file: lost.exr: no such file"},
        {"{type: environment, file: sky.jpg}",
         "36: file: sky.jpg: expected an image file .exr, .hdr or .png, got '.jpg'"},
        {"{type: environment, file: sky.exr, scale: -1}",
         "52: scale: expected a number >= 0, got '-1'"},
        {"{type: environment, file: sky.exr, rotate: 1}",
         "45: rotate: unknown key, expected one of type, group, radiance, file, rotate_deg, scale"},
        {"{type: environment, file: huge.exr, scale: 10}",
         "53: scale: expected at most 1e+30 altogether, got 10 times the image's 2e+29"},
        {"{type: environment, file: sky.exr}, {type: environment, radiance: 2}",
         "46: expected one environment, got a second; the first is at scene.yaml:2:10"},
        {"{type: quad, position: [0, 9, 0], look_at: [9, 9, 0], size: [1, 1], radiance: 1, "
         "texture: lost.png}",
         "100: texture: lost.png: no such file"},
        {"{type: quad, position: [0, 9, 0], look_at: [9, 9, 0], size: [1, 1], texture: sky.exr}",
         "10: missing key 'radiance'"},
        {"{type: quad, position: [0, 9, 0], look_at: [9, 9, 0], size: [1, 1], radiance: 6, "
         "texture: huge.exr}",
         "88: radiance: expected at most 1e+30 altogether, got 6 times the image's 2e+29"},
        {"{type: disc, position: [0, 0, 0], radius: 1, radiance: 1}",
         "10: missing key 'look_at' or 'direction'"},
        {"{type: disc, position: [0, 0, 0], direction: [0, 1, 0], radius: 0, radiance: 1}",
         "74: radius: expected a number > 0, got '0'"},
        {"{type: disc, position: [0, 0, 0], direction: [0, 1, 0], look_at: [1, 0, 0], radius: 1, "
         "radiance: 1}",
         "44: direction: cannot be given together with 'look_at'"},
        {"{type: mesh, radiance: 1}", "10: missing key 'file'"},
        {"{type: mesh, file: triangle.off}", "10: missing key 'radiance'"},
        {"{type: mesh, file: lost.ply, radiance: 1}", "29: file: lost.ply: no such file"},
        {"{type: mesh, file: broken.off, radiance: 1}",
         "29: file: broken.off: line 2: 3 vertices do not fit in the 6 bytes that follow"},
        {"{type: mesh, file: triangle.off, radiance: 1, transform: [{scale: 0}]}",
         "76: scale: expected a factor of magnitude in [1e-06, 1e+06], got '0'"},
        {"{type: mesh, file: triangle.off, radiance: 1, normals: flat}",
         "56: normals: unknown key, expected one of type, group, file, transform, radiance"},
    };
    for (const auto& [lights, message] : rows) EXPECT_EQ(error(lights), where + message) << lights;
    EXPECT_EQ(error("{type: environment, file: text.exr}")
                  .find(where + "36: file: text.exr: not a readable OpenEXR image: "),
              0u);
}

// What pass one has to be run again for.
TEST_F(LightFiles, Fingerprint) {
    const auto pairs = [&](const std::string& lights) {
        return scene_fingerprint(scene(lights), SceneGeometry{});
    };
    const std::string sky = "{type: environment, file: sky.exr";
    const Fingerprint before = pairs(sky + "}");
    EXPECT_EQ(pairs(sky + "}"), before);
    EXPECT_NE(pairs(sky + ", rotate_deg: 1}"), before);
    EXPECT_NE(pairs(sky + ", scale: 2}"), before);
    std::filesystem::copy_file(folder_ / "sky.exr", folder_ / "copy.exr");
    EXPECT_EQ(pairs("{type: environment, file: copy.exr}"), before) << "contents, not names";
    write_sky("sky.exr", 1.5f);
    EXPECT_NE(pairs(sky + "}"), before);

    const std::string lamp = "{type: mesh, file: triangle.off, radiance: 1";
    EXPECT_EQ(pairs(lamp + "}"), pairs(lamp + "}"));
    EXPECT_NE(pairs(lamp + "}"), pairs(lamp + ", transform: [{scale: 2}]}"));
    const std::string quad =
        "{type: quad, position: [0, 9, 0], look_at: [9, 9, 0], size: [1, 1], radiance: 1";
    EXPECT_NE(pairs(quad + "}"), pairs(quad + ", texture: sky.exr}"));
    EXPECT_NE(pairs(quad + ", texture: copy.exr}"), pairs(quad + ", texture: sky.exr}"));
}

}  // namespace
}  // namespace tallow
