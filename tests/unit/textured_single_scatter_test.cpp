// SPDX-License-Identifier: Apache-2.0
// Single scattering is tinted where light enters and where it leaves.
#include <gtest/gtest.h>

#include "render/single_scatter.h"
#include "tests/support/ball_mesh.h"
#include "tests/support/half_space.h"
#include "tests/support/scenes.h"

namespace tallow {
namespace {

using test::up_direction;

/// Scattered once in a body below the origin, seen from w_o at the point under x.
Rgb seen(Scene scene, const Surface& surface, const SurfaceColor& albedo, Vec3 x, Vec3 w_o,
         bool exact) {
    scene.objects = {{SphereShape{1}, 0, {}, ""}};
    const std::vector<Surface> surfaces = {surface};
    const RayScene rays(surfaces);
    const RefractedConnections connections(surface, 1.5f);
    const auto hit = rays.intersect({x + Vec3(0, 1, 0), Vec3(0, -1, 0)});
    if (!hit) return Rgb(-1);
    const Medium medium = test::marble();
    return single_scatter({scene, rays, surface, 0, medium, exact ? &connections : nullptr, albedo},
                          {*hit, w_o, 7}, lone_steps(64));
}

SurfaceColor checker(Texture::Coordinates coordinates, float period) {
    SurfaceColor color(Rgb(1));
    color.texture = std::make_shared<Texture>(
        Texture{CheckerTexture{Rgb(0.64f), Rgb(0.25f)}, coordinates, Vec3(period)});
    return color;
}

void expect_ratio(Rgb a, Rgb b, float ratio) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], ratio * b[c], 2e-6f * b[c]);  // measured 1e-7
}

const Surface kPlane = PlaneSurface{Vec3(0), Vec3(0, 1, 0), 1e5f};

TEST(TexturedSingleScatter, ConstantAlbedoIsAFactor) {
    const Scene scene = test::lit_scene({DirectionalLight{-up_direction(0.7f, 1), Rgb(1)}});
    for (const bool exact : {false, true}) {
        const auto with = [&](const SurfaceColor& albedo) {
            return seen(scene, kPlane, albedo, Vec3(0), up_direction(0.6f, 2), exact);
        };
        const Rgb white = with(Rgb(1)), tinted = with(Rgb(0.5f, 0.25f, 0));
        EXPECT_GT(min_channel(white), 0);
        EXPECT_NEAR(tinted.r, 0.5f * white.r, 1e-6f * white.r);
        EXPECT_NEAR(tinted.g, 0.25f * white.g, 1e-6f * white.g);
        EXPECT_EQ(tinted.b, 0);
    }
}

// Straight in and straight out: at the same place.
TEST(TexturedSingleScatter, NormalLightSeesOneSquare) {
    const Scene scene = test::lit_scene({DirectionalLight{{0, -1, 0}, Rgb(1)}});
    for (const auto coordinates : {Texture::Coordinates::uv, Texture::Coordinates::object})
        for (const bool exact : {false, true}) {
            const SurfaceColor tiles = checker(coordinates, 20);
            const auto at = [&](float x, const SurfaceColor& albedo) {
                return seen(scene, kPlane, albedo, Vec3(x, 0, -3), Vec3(0, 1, 0), exact);
            };
            // Object space continues the squares in z, so that z = -3 swaps them.
            const bool uv = coordinates == Texture::Coordinates::uv;
            expect_ratio(at(3, tiles), at(3, Rgb(1)), uv ? 0.64f : 0.25f);
            expect_ratio(at(-3, tiles), at(-3, Rgb(1)), uv ? 0.25f : 0.64f);
        }
}

// Light from +x enters there, where the square is another than that under the eye.
TEST(TexturedSingleScatter, EntryAndExitCountOnceEach) {
    const Scene scene = test::lit_scene({DirectionalLight{-up_direction(0.5f, 0), Rgb(1)}});
    for (const bool exact : {false, true}) {
        const SurfaceColor tiles = checker(Texture::Coordinates::uv, 4000);
        const auto at = [&](const SurfaceColor& albedo) {
            return seen(scene, kPlane, albedo, Vec3(0, 0, -9), Vec3(0, 1, 0), exact);
        };
        // The border, shifted by a thousandth of a square, lies at x = -2: 0 is on its even side.
        expect_ratio(at(tiles), at(Rgb(1)), 0.64f);
        const auto beyond = [&](const SurfaceColor& albedo) {
            return seen(scene, kPlane, albedo, Vec3(-2.0001f, 0, -9), Vec3(0, 1, 0), exact);
        };
        // A depth in 1e4 is so shallow that it is lit from the eye's side: measured 3e-5.
        const Rgb got = beyond(tiles), white = beyond(Rgb(1));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c] / white[c], 0.8f * 0.5f, 1e-3f);
    }
}

// On a mesh, exact connections have no uv of their own: they must find it.
TEST(TexturedSingleScatter, ExactConnectionsFindTheUvsOfAMesh) {
    TriangleMesh ball = test::sphere_mesh(3, 10);
    ball.corner_uvs.assign(3 * ball.triangles.size(), Vec2(0.75f, 0.25f));
    const Scene scene = test::lit_scene({DirectionalLight{-up_direction(0.7f, 1), Rgb(1)}});
    const Vec3 x(1, 9, 2), w_o = up_direction(0.9f, 2);
    const Rgb white = seen(scene, ball, Rgb(1), x, w_o, true);
    EXPECT_GT(min_channel(white), 0);
    expect_ratio(seen(scene, ball, checker(Texture::Coordinates::uv, 1), x, w_o, true), white,
                 0.25f);
}

}  // namespace
}  // namespace tallow
