// SPDX-License-Identifier: Apache-2.0
#include "common/scene/textures_yaml.h"

#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "common/scene/scene_geometry.h"
#include "tests/support/error_text.h"
#include "tests/support/scene_text.h"
#include "tests/support/test_files.h"
#include "tests/support/texture_files.h"

namespace tallow {
namespace {

constexpr auto kUv = Texture::Coordinates::uv, kObject = Texture::Coordinates::object;

const std::string kBoard = "board: {type: checker, even: 0.8, odd: [0.1, 0.2, 0.3]";

/// A scene of these textures and one of each material that takes them.
std::string text(const std::string& textures, const std::string& reflectance = "0.5",
                 const std::string& albedo = "1") {
    return kCamera + "textures: {" + textures +
           "}\nmaterials:\n  floor: {type: diffuse, reflectance: " + reflectance +
           "}\n  cup: {type: plastic, reflectance: " + reflectance +
           "}\n  body: {type: subsurface, preset: marble, albedo: " + albedo + "}\n";
}

const SurfaceColor& floor_color(const Scene& scene) {
    return std::get<DiffuseMaterial>(scene.materials[0].kind).reflectance;
}
const SurfaceColor& cup_color(const Scene& scene) {
    return std::get<PlasticMaterial>(scene.materials[1].kind).reflectance;
}
const SurfaceColor& body_color(const Scene& scene) {
    return std::get<SubsurfaceMaterial>(scene.materials[2].kind).albedo;
}

TEST(TexturesYaml, ReadsACheckerForEveryMaterial) {
    const Scene scene =
        scene_of(text(kBoard + "}", "{texture: board, scale: [1, 0.5, 0.25]}", "{texture: board}"));
    const Texture& texture = *body_color(scene).texture;
    EXPECT_EQ(std::get<CheckerTexture>(texture.kind).even, Rgb(0.8f));
    EXPECT_EQ(std::get<CheckerTexture>(texture.kind).odd, Rgb(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(texture.coordinates, kUv);
    EXPECT_EQ(texture.period, Vec3(1));
    EXPECT_EQ(body_color(scene).value, Rgb(1));
    EXPECT_EQ(floor_color(scene).texture, body_color(scene).texture);
    EXPECT_EQ(floor_color(scene).value, Rgb(1, 0.5f, 0.25f));
    EXPECT_EQ(cup_color(scene).texture, body_color(scene).texture);
    EXPECT_EQ(texture_of(scene.materials[1]), &texture);
}

TEST(TexturesYaml, ConstantsStayConstants) {
    const Scene scene = scene_of(text("", "0.25", "[0.5, 0.6, 0.7]"));
    EXPECT_EQ(floor_color(scene).value, Rgb(0.25f));
    EXPECT_EQ(body_color(scene).value, Rgb(0.5f, 0.6f, 0.7f));
    EXPECT_EQ(body_color(scene).texture, nullptr);
    EXPECT_EQ(texture_of(scene.materials[0]), nullptr);
}

Texture texture_with(const std::string& keys, const std::vector<std::string>& overrides = {}) {
    return *floor_color(
                scene_of("unit: cm\n" + text(kBoard + keys + "}", "{texture: board}"), overrides))
                .texture;
}

TEST(TexturesYaml, PeriodsAreLengthsInObjectSpaceOnly) {
    EXPECT_EQ(texture_with(", period: 0.25").period, Vec3(0.25f));
    EXPECT_EQ(texture_with(", coordinates: uv, period: [0.25, 4]").period, Vec3(0.25f, 4, 1));
    const Texture texture = texture_with(", coordinates: object, period: [1, 2, 0.5]");
    EXPECT_EQ(texture.coordinates, kObject);
    EXPECT_EQ(texture.period, Vec3(10, 20, 5));
    EXPECT_EQ(texture_with(", coordinates: object, period: 3").period, Vec3(30));
}

TEST(TexturesYaml, CanBeOverridden) {
    EXPECT_EQ(texture_with(", period: 2", {"textures.board.period=[3, 4]"}).period, Vec3(3, 4, 1));
    EXPECT_EQ(texture_with("", {"textures.board.period=3"}).period, Vec3(3));
    const Texture other = texture_with(
        "", {"textures.board={type: checker, even: 0, odd: 1, coordinates: object, period: 1}"});
    EXPECT_EQ(other.period, Vec3(10));
    const Scene scene =
        scene_of(text(kBoard + "}"), {"materials.body.albedo={texture: board, scale: 0.5}"});
    EXPECT_NE(body_color(scene).texture, nullptr);
    EXPECT_EQ(body_color(scene).value, Rgb(0.5f));
    EXPECT_EQ(error_text<UsageError>([] { texture_with("", {"textures.board.period=-1"}); }),
              "--set textures.board.period: expected a number > 0, got '-1'");
}

TEST(TexturesYaml, ReadsImagesBesideTheScene) {
    const auto folder = fresh_folder();
    test::write_picture(folder / "wood.exr", 2, 1, {Rgb(0.25f), Rgb(1, 0, 0.5f)});
    const Scene scene =
        parse_scene(text("wood: {type: image, file: wood.exr, coordinates: object, period: 7}, "
                         "fine: {type: image, file: wood.exr}",
                         "{texture: wood}", "{texture: fine}"),
                    folder / "scene.yaml");
    const auto& image = std::get<ImageTexture>(floor_color(scene).texture->kind).image;
    EXPECT_EQ(image->width, 2);
    EXPECT_EQ(image->pixels, (std::vector<Rgb>{Rgb(0.25f), Rgb(1, 0, 0.5f)}));
    EXPECT_EQ(floor_color(scene).texture->period, Vec3(7));
    // Read once, however many textures show it.
    EXPECT_EQ(std::get<ImageTexture>(body_color(scene).texture->kind).image, image);
}

std::string complaint(const std::string& scene, const std::filesystem::path& file = "s.yaml") {
    return error_text<InputError>([&] { parse_scene(scene, file); });
}

TEST(TexturesYaml, RefusesWrongTextures) {
    const std::pair<const char*, const char*> rows[] = {
        {"a: {type: marble}", "2:22: type: expected one of checker, image, got 'marble'"},
        {"a: {even: 1}", "2:15: missing key 'type'"},
        {"a: {type: checker, even: 1}", "2:15: missing key 'odd'"},
        {"a: {type: checker, even: 1.5, odd: 0}",
         "2:37: even: expected a number in [0, 1], got '1.5'"},
        {"a: {type: checker, even: 1, odd: 0, file: x.png}",
         "2:48: file: unknown key, expected one of type, even, odd, coordinates, period"},
        {"a: {type: checker, even: 1, odd: 0, coordinates: world}",
         "2:61: coordinates: expected one of uv, object, got 'world'"},
        {"a: {type: checker, even: 1, odd: 0, coordinates: object}", "2:15: missing key 'period'"},
        {"a: {type: checker, even: 1, odd: 0, period: 0}",
         "2:56: period: expected a number > 0, got '0'"},
        {"a: {type: checker, even: 1, odd: 0, period: [1, 2, 3]}",
         "2:56: period: expected a number or two [u, v], got a list of 3"},
        {"a: {type: checker, even: 1, odd: 0, coordinates: object, period: [1, 2]}",
         "2:77: period: expected a number or three [x, y, z], got a list of 2"},
        {"a: {type: checker, even: 1, odd: 0, coordinates: object, period: [1, 2, -1]}",
         "2:84: period: expected a number > 0, got '-1'"},
        {"a: {type: image}", "2:15: missing key 'file'"},
        {"a: {type: image, file: none.png}", "2:35: file: none.png: no such file"},
        {"a.b: {type: image}", "2:12: expected a name without '.', ',', '=', got 'a.b'"},
        {"a: 7", "2:15: a: expected a map, got '7'"},
    };
    for (const auto& [textures, message] : rows)
        EXPECT_EQ(complaint(text(textures)), std::string("s.yaml:") + message) << textures;
    EXPECT_EQ(complaint(kCamera + "textures: [1]\n"),
              "s.yaml:2:11: textures: expected a map, got a list of 1");
}

TEST(TexturesYaml, RefusesWrongReferences) {
    const std::string boards = kBoard + "}, tiles: {type: checker, even: 0, odd: 1}";
    const std::pair<const char*, const char*> rows[] = {
        {"{texture: bord}", "49: texture: expected one of board, tiles, got 'bord'"},
        {"{scale: 1}", "39: missing key 'texture'"},
        {"{texture: board, period: 1}", "56: period: unknown key, expected one of texture, scale"},
        {"{texture: [board]}", "49: texture: expected a text, got a list of 1"},
        {"{texture: board, scale: -1}", "63: scale: expected a number >= 0, got '-1'"},
        {"{texture: board, scale: [1, 1, 4]}",
         "39: reflectance: even of texture board: expected colours of at most 1 times scale, got "
         "3.2"},
        {"", "26: reflectance: expected a number, three [r, g, b] or {texture: NAME}, got nothing"},
        {"1.5", "39: reflectance: expected a number in [0, 1], got '1.5'"},
    };
    for (const auto& [reference, message] : rows)
        EXPECT_EQ(complaint(text(boards, reference)), std::string("s.yaml:4:") + message)
            << reference;
    EXPECT_EQ(complaint(text("", "0.5", "{texture: board}")),
              "s.yaml:6:62: texture: expected a name from textures, which is empty, got 'board'");
    EXPECT_EQ(complaint(kCamera + "materials: {m: {type: mirror, reflectance: {texture: x}}}\n"),
              "s.yaml:2:44: reflectance: expected a number or three [r, g, b], got a map");
}

TEST(TexturesYaml, RefusesImagesThatReflectMoreThanTheyGet) {
    const auto folder = fresh_folder();
    test::write_picture(folder / "a.exr", 2, 2, {Rgb(1), Rgb(1), Rgb(0.5f, 1.25f, 1), Rgb(3)});
    const auto message = [&](const std::string& reference) {
        const std::string error =
            complaint(text("a: {type: image, file: a.exr}", "1", reference), folder / "scene.yaml");
        return error.substr(std::min(error.size(), (folder / "").string().size()));
    };
    const std::string pixel = "albedo: " + (folder / "a.exr").string() + ": pixel (0, 1): ";
    EXPECT_EQ(message("{texture: a}"),
              "scene.yaml:6:52: " + pixel + "expected colours of at most 1, got 1.25");
    EXPECT_EQ(message("{texture: a, scale: [1, 0.9, 0.3]}"),
              "scene.yaml:6:52: " + pixel + "expected colours of at most 1 times scale, got 1.125");
    EXPECT_EQ(message("{texture: a, scale: 0.333}"), "");
}

TEST(TexturesYaml, MeshesMustHaveTheUvsThatTheirTextureNeeds) {
    const auto folder = fresh_folder();
    const std::string shape = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    write_bytes(folder / "bare.obj", shape + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    write_bytes(folder / "part.obj",
                shape + "vt 0 0\nf 1/1 3/1 2/1\nf 1 2 4\nf 1 4 3\nf 2/1 3/1 4\n");
    write_bytes(folder / "full.obj",
                shape + "vt 0 0\nf 1/1 3/1 2/1\nf 1/1 2/1 4/1\nf 1/1 4/1 3/1\nf 2/1 3/1 4/1\n");
    const auto message = [&](const std::string& mesh, const std::string& coordinates) {
        const Scene scene = parse_scene(text(kBoard + coordinates + "}", "{texture: board}") +
                                            "objects:\n  - {shape: mesh, file: " + mesh +
                                            ".obj, material: floor}\n",
                                        folder / "scene.yaml");
        Stats stats;
        const std::string error = error_text<InputError>([&] { load_geometry(scene, stats); });
        const auto prefix = (folder / "scene.yaml").string() + ":8:5: " + folder.string() + "/";
        EXPECT_TRUE(error.empty() || error.starts_with(prefix)) << error;
        return error.substr(std::min(error.size(), prefix.size()));
    };
    const std::string what =
        " no texture coordinates, which the texture of material 'floor' needs; give the texture "
        "'coordinates: object'";
    EXPECT_EQ(message("bare", ""), "bare.obj: this mesh has" + what);
    EXPECT_EQ(message("part", ""), "part.obj: 7 of this mesh's 12 corners have" + what);
    EXPECT_EQ(message("full", ""), "");
    EXPECT_EQ(message("bare", ", coordinates: object, period: 1"), "");
}

}  // namespace
}  // namespace tallow
