// SPDX-License-Identifier: Apache-2.0
#include "common/scene/texture.h"

#include <gtest/gtest.h>

#include "common/scene/scene.h"

namespace tallow {
namespace {

constexpr auto kUv = Texture::Coordinates::uv, kObject = Texture::Coordinates::object;
const Rgb kEven(0.9f, 0.8f, 0.7f), kOdd(0.1f, 0.2f, 0.3f);

Texture checker(Texture::Coordinates coordinates, Vec3 period) {
    return {CheckerTexture{kEven, kOdd}, coordinates, period};
}

/// Each pixel a colour of its own: (x, y, 1) / 16.
Texture picture(int width, int height, Vec3 period = Vec3(1)) {
    RgbImage image{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) image.pixels.push_back(Rgb(float(x), float(y), 1) / 16.0f);
    return {ImageTexture{std::make_shared<RgbImage>(image)}, kUv, period};
}

Rgb at_uv(const Texture& texture, float u, float v) { return look_up(texture, {{u, v}, Vec3(9)}); }
Rgb at_object(const Texture& texture, Vec3 p) { return look_up(texture, {Vec2(0.3f), p}); }

TEST(Texture, CheckerHasTwoSquaresAPeriod) {
    const Texture texture = checker(kUv, {0.5f, 2, 1});
    for (int i = -6; i < 6; ++i)
        for (int j = -6; j < 6; ++j)
            EXPECT_EQ(at_uv(texture, 0.25f * (float(i) + 0.5f), float(j) + 0.5f),
                      (i + j) % 2 == 0 ? kEven : kOdd)
                << i << " " << j;
}

TEST(Texture, CheckerOfObjectSpaceIsOfCubes) {
    const Texture texture = checker(kObject, {2, 4, 6});
    for (int i = -3; i < 3; ++i)
        for (int j = -3; j < 3; ++j)
            for (int k = -3; k < 3; ++k)
                EXPECT_EQ(at_object(texture, (Vec3(i, j, k) + 0.5f) * Vec3(1, 2, 3)),
                          (i + j + k) % 2 == 0 ? kEven : kOdd);
}

// A floor at y = 0 is of one colour within a square, whatever rounding did to its points.
TEST(Texture, RoundingDoesNotTearASurfaceInABorder) {
    const Texture texture = checker(kObject, Vec3(10));
    for (const float y : {-1e-5f, -1e-7f, -0.0f, 0.0f, 1e-7f, 1e-5f})
        EXPECT_EQ(at_object(texture, {2, y, 2}), kEven) << y;
}

TEST(Texture, PixelCentresAreExact) {
    const Texture texture = picture(4, 8);
    for (int x = 0; x < 4; ++x)
        for (int y = 0; y < 8; ++y)
            EXPECT_EQ(at_uv(texture, (float(x) + 0.5f) / 4, 1 - (float(y) + 0.5f) / 8),
                      Rgb(float(x), float(y), 1) / 16.0f);
}

TEST(Texture, BetweenPixelCentresIsBilinear) {
    const Texture texture = picture(4, 8);
    const Rgb got = at_uv(texture, 1.75f / 4, 1 - 3.625f / 8);
    EXPECT_NEAR(got.r, 1.25f / 16, 1e-7f);
    EXPECT_NEAR(got.g, 3.125f / 16, 1e-7f);
    EXPECT_EQ(got.b, 1 / 16.0f);  // what is constant stays exactly so
}

TEST(Texture, PicturesRepeatAcrossBorders) {
    const Texture texture = picture(4, 8);
    // Half way between the last column and the first, the last row and the first.
    for (const float u : {0.0f, 1.0f, -1.0f, 5.0f}) EXPECT_EQ(at_uv(texture, u, 0.3f).r, 1.5f / 16);
    for (const float v : {0.0f, 1.0f, -3.0f}) EXPECT_EQ(at_uv(texture, 0.3f, v).g, 3.5f / 16);
    for (const float shift : {-1.0f, 1.0f, -4.0f}) {
        const Rgb here = at_uv(texture, 0.375f, 0.8125f);
        EXPECT_EQ(at_uv(texture, 0.375f + shift, 0.8125f - shift), here);
        EXPECT_EQ(at_uv(picture(4, 8, {2, 4, 1}), 2 * (0.375f + shift), 4 * 0.8125f), here);
    }
    EXPECT_EQ(at_uv(picture(1, 1), 0.123f, -77.7f), Rgb(0, 0, 1 / 16.0f));
}

TEST(Texture, FarFromTheOriginColoursStayColours) {
    const Texture texture = picture(4, 8, Vec3(1e-12f));
    for (const float u : {1e9f, -1e9f, 3.4e38f, -3.4e38f, 1e-38f, -1e-38f}) {
        const Rgb got = at_uv(texture, u, -u);
        EXPECT_TRUE(got.r >= 0 && got.r <= 3 / 16.0f && got.g >= 0 && got.g <= 7 / 16.0f) << u;
        const Rgb square = at_uv(checker(kUv, Vec3(1e-12f)), u, u);
        EXPECT_TRUE(square == kEven || square == kOdd) << u;
    }
}

Scene textured_scene(const SurfaceColor& color) {
    Scene scene;
    SubsurfaceMaterial body;
    body.albedo = color;
    scene.materials = {{"body", body}, {"floor", DiffuseMaterial{color}}};
    // Turned, stretched and moved: x_world = (-2 z, 3 y, x) + (10, 20, 30).
    scene.objects = {{SphereShape{1}, 0, {{{0, 0, 1}, {0, 3, 0}, {-2, 0, 0}}, {10, 20, 30}}, ""},
                     {SphereShape{1}, 1, {}, ""}};
    return scene;
}

TEST(Texture, ObjectPositionUndoesTheTransform) {
    Hit hit{};
    hit.position = Vec3(10, 20, 30) + Vec3(-2 * 7, 3 * 6, 5);
    hit.uv = {0.25f, 0.5f};
    const TexturePoint point = texture_point(textured_scene({}), hit);
    EXPECT_EQ(point.object_position, Vec3(5, 6, 7));
    EXPECT_EQ(point.uv, hit.uv);
}

TEST(Texture, TintIsTheRootOfTheAlbedo) {
    Hit hit{};
    const Scene plain = textured_scene(Rgb(0.25f, 0.81f, 1));
    EXPECT_EQ(surface_tint(plain, subsurface(plain, 0)->albedo, hit), Rgb(0.5f, 0.9f, 1));
    EXPECT_EQ(texture_value(plain, hit), Rgb(1));

    SurfaceColor color(Rgb(0.5f));
    color.texture =
        std::make_shared<Texture>(Texture{CheckerTexture{Rgb(0.5f), Rgb(0.02f)}, kUv, Vec3(2)});
    const Scene scene = textured_scene(color);
    hit.uv = {0.5f, 0.5f};
    EXPECT_EQ(surface_tint(scene, subsurface(scene, 0)->albedo, hit), Rgb(0.5f));
    EXPECT_EQ(texture_value(scene, hit), Rgb(0.5f));
    hit.uv.x = 1.5f, hit.object = 1;
    EXPECT_EQ(texture_value(scene, hit), Rgb(0.02f));
}

}  // namespace
}  // namespace tallow
