// SPDX-License-Identifier: Apache-2.0
// Texture coordinates of what rays hit.
#include <gtest/gtest.h>

#include "common/geometry/ray_scene.h"

namespace tallow {
namespace {

/// Where a ray from `from` to `to` meets the surface.
Vec2 uv_between(const Surface& surface, Vec3 from, Vec3 to) {
    const std::vector<Surface> surfaces = {surface};
    const auto hit = RayScene(surfaces).intersect({from, glm::normalize(to - from)});
    EXPECT_TRUE(hit.has_value());
    return hit ? hit->uv : Vec2(NAN);
}

void expect_uv(Vec2 uv, Vec2 expected) {
    EXPECT_LT(glm::distance(uv, expected), 1e-6f)  // measured 2e-7
        << uv.x << " " << uv.y << ", expected " << expected.x << " " << expected.y;
}

const glm::mat3 kTurnAboutY(0, 0, -1, 0, 1, 0, 1, 0, 0);  // x -> -z, z -> x

TEST(HitUv, SphereHasLongitudeAndLatitude) {
    const Vec3 c(5, -3, 2);
    const SphereSurface sphere{{glm::mat3(4), c}};
    const auto uv = [&](Vec3 d) { return uv_between(sphere, c + 9.0f * d, c); };
    expect_uv(uv({0, 0, 1}), {0.5f, 0.5f});
    expect_uv(uv({1, 0, 0}), {0.75f, 0.5f});
    expect_uv(uv({-1, 0, 0}), {0.25f, 0.5f});
    EXPECT_EQ(uv({0, 1, 0}).y, 1);
    EXPECT_EQ(uv({0, -1, 0}).y, 0);
    const float s = std::sqrt(0.5f);
    expect_uv(uv({s / std::sqrt(2.0f), s, s / std::sqrt(2.0f)}), {0.625f, 0.75f});
    // A hair on either side of the seam.
    EXPECT_GT(uv(glm::normalize(Vec3(1e-3f, 0, -1))).x, 0.999f);
    EXPECT_LT(uv(glm::normalize(Vec3(-1e-3f, 0, -1))).x, 0.001f);
    // Turned with its object: what faced +z now faces +x.
    expect_uv(uv_between(SphereSurface{{4.0f * kTurnAboutY, c}}, c + Vec3(9, 0, 0), c),
              {0.5f, 0.5f});
}

TEST(HitUv, EachFaceOfACubeHasItsOwnSquare) {
    const TriangleMesh cube = cube_mesh({glm::mat3(2, 0, 0, 0, 4, 0, 0, 0, 6), Vec3(0)});
    // A quarter of the way right and three quarters up, as seen from outside.
    const Vec2 there(0.25f, 0.75f);
    expect_uv(uv_between(cube, {-0.5f, 1, 9}, {-0.5f, 1, 0}), there);
    expect_uv(uv_between(cube, {0.5f, 1, -9}, {0.5f, 1, 0}), there);
    expect_uv(uv_between(cube, {9, 1, 1.5f}, {0, 1, 1.5f}), there);
    expect_uv(uv_between(cube, {-9, 1, -1.5f}, {0, 1, -1.5f}), there);
    expect_uv(uv_between(cube, {-0.5f, 9, -1.5f}, {-0.5f, 0, -1.5f}), there);
    expect_uv(uv_between(cube, {-0.5f, -9, 1.5f}, {-0.5f, 0, 1.5f}), there);
}

TEST(HitUv, DiscAndPlane) {
    const DiscSurface disc{{glm::mat3(2), Vec3(1, 1, 1)}};
    expect_uv(uv_between(disc, {1, 1, 5}, {1, 1, 1}), {0.5f, 0.5f});
    expect_uv(uv_between(disc, {2, 0, 5}, {2, 0, 1}), {0.75f, 0.25f});

    const PlaneSurface floor{{1, 2, 3}, {0, 1, 0}};
    expect_uv(uv_between(floor, {4, 9, -4}, {4, 2, -4}), {3, 7});
    const PlaneSurface wall{{1, 2, 3}, {0, 0, 1}};
    expect_uv(uv_between(wall, {4, 9, 9}, {4, 9, 3}), {3, 7});
}

TEST(HitUv, MeshInterpolatesItsCorners) {
    TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {}, {}};
    EXPECT_EQ(uv_between(mesh, {0.25f, 0.5f, 1}, {0.25f, 0.5f, 0}), Vec2(0));
    mesh.corner_uvs = {{3, 1}, {7, 1}, {3, -7}};
    expect_uv(uv_between(mesh, {0.25f, 0.5f, 1}, {0.25f, 0.5f, 0}), {4, -3});
}

}  // namespace
}  // namespace tallow
