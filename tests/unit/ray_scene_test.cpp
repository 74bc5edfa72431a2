// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/ray_scene.h"

#include <gtest/gtest.h>

#include <memory>

#include "common/base/rng.h"
#include "tests/support/count_threads.h"

namespace tallow {
namespace {

// Embree shares the scheduler: a scene must neither take threads away nor bring some back.
TEST(RayScene, LeavesTheNumberOfThreadsAlone) {
    const std::vector<Surface> surfaces = {SphereSurface{}, cube_mesh({})};
    for (int threads : {1, 2}) {
        const auto expected = std::size_t(threads);
        const ThreadLimit limit(threads);
        {
            const RayScene rays(surfaces);
            EXPECT_EQ(allowed_threads(), threads);
            EXPECT_EQ(threads_in_a_loop(expected), expected);
        }
        EXPECT_EQ(allowed_threads(), threads);
        EXPECT_EQ(threads_in_a_loop(expected), expected);
    }
}

TEST(RayScene, LeavesTheThreadsOfAnUnlimitedProcess) {
    const std::vector<Surface> surfaces = {SphereSurface{}};
    const int before = allowed_threads();
    const RayScene rays(surfaces);
    EXPECT_EQ(allowed_threads(), before);
}

// From a camera, side by side: a sphere before a cube before a plane, and nothing.
TEST(RayScene, PacketsAreAsSingleRays) {
    const glm::mat3 size(4.0f);
    const std::vector<Surface> surfaces = {cube_mesh({size, Vec3(0.1f, 0.2f, 0)}),
                                           SphereSurface{{glm::mat3(0.7f), Vec3(0.3f, 0.2f, 4)}},
                                           PlaneSurface{Vec3(0, -3, 0), Vec3(0, 1, 0)}};
    const RayScene scene(surfaces);
    std::vector<Ray> rays;
    for (int i = 0; i < 400; ++i) {
        const Vec3 to(0.5f * float(i % 20) - 5, 0.5f * float(i / 20) - 5, 0);
        rays.push_back({Vec3(0, 0, 12), glm::normalize(to - Vec3(0, 0, 12))});
    }
    rays.resize(391);  // no whole number of packets
    std::vector<std::optional<Hit>> hits(rays.size());
    scene.intersect(rays, hits);
    int met[3] = {}, nothing = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const auto single = scene.intersect(rays[i]);
        ASSERT_EQ(hits[i].has_value(), single.has_value()) << i;
        if (!single) {
            ++nothing;
            continue;
        }
        ++met[single->object];
        EXPECT_EQ(hits[i]->object, single->object) << i;
        EXPECT_LT(glm::distance(hits[i]->position, single->position), 1e-4) << i;
        EXPECT_LT(glm::distance(hits[i]->n, single->n), 1e-4) << i;
        EXPECT_NEAR(hits[i]->t, single->t, 1e-4) << i;
    }
    for (const int count : {met[0], met[1], met[2], nothing}) EXPECT_GT(count, 5);
}

// Rays in bundles meet what single rays meet: a mesh, a sphere inside it that is stepped over, and
// a plane.
TEST(RayScene, BundlesAreAsSingleRays) {
    const glm::mat3 size(4.0f);
    const std::vector<Surface> surfaces = {cube_mesh({size, Vec3(0)}),
                                           SphereSurface{{glm::mat3(0.7f), Vec3(0.3f)}},
                                           PlaneSurface{Vec3(0, -3, 0), Vec3(0, 1, 0)}};
    const RayScene scene(surfaces);
    std::vector<ShadowRay> rays;  // 50: three whole bundles and a part of one
    for (std::uint32_t i = 0; i < 50; ++i) {
        const Vec2 u = sobol_2d(i, 7);
        const float z = 1 - 2 * u.x, s = std::sqrt(1 - z * z);
        const Vec3 direction(s * std::cos(kTwoPi * u.y), z, s * std::sin(kTwoPi * u.y));
        rays.push_back({Vec3(-1, 0.1f, 0), direction, i % 5 == 0 ? 2.0f : kInfinity});
    }
    for (std::uint32_t object = 0; object < surfaces.size(); ++object) {
        std::vector<std::optional<Hit>> hits(rays.size());
        scene.intersect_object(rays, object, hits);
        int found = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const auto& [origin, direction, length] = rays[i];
            const auto single = scene.intersect_object({origin, direction}, object, length);
            ASSERT_EQ(hits[i].has_value(), single.has_value()) << object << ' ' << i;
            if (!single) continue;
            ++found;
            EXPECT_NEAR(hits[i]->t, single->t, 2e-6f * single->t);  // measured 4e-7
            EXPECT_LT(glm::length(hits[i]->position - single->position), 5e-6f);
            EXPECT_LT(glm::length(hits[i]->n - single->n), 5e-6f);
        }
        EXPECT_GT(found, 2) << object;
    }
    const auto blocked = std::make_unique<bool[]>(rays.size());
    scene.occluded(rays, {blocked.get(), rays.size()});
    for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(blocked[i], scene.occluded(rays[i]));
}

}  // namespace
}  // namespace tallow
