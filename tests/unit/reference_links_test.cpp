// SPDX-License-Identifier: Apache-2.0
// Links from a point inside a body to the camera, against the search for all refracted paths that
// pass two has, which knows nothing of beams.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/base/rng.h"
#include "experiments/reference/mesh_body.h"
#include "experiments/reference/sphere_body.h"
#include "render/refracted_connection.h"
#include "tests/support/ball_mesh.h"

namespace tallow::reference {
namespace {

Vec3 random_point(float radius, std::uint64_t i) {
    const auto u = [&](std::uint64_t stream) { return to_unit_float(random_bits(7, stream, i)); };
    const float z = 2 * u(0) - 1, phi = kTwoPi * u(1), s = std::sqrt(1 - z * z);
    return radius * std::cbrt(u(2)) * Vec3(s * std::cos(phi), s * std::sin(phi), z);
}

template <class Body>
std::vector<CameraLink> links_of(const Body& body, Vec3 x, float reach) {
    std::vector<CameraLink> links;
    body.links(x, reach, [&](const CameraLink& link) { links.push_back(link); });
    return links;
}

std::vector<RefractedPath> paths_of(const Surface& surface, float eta, Vec3 x, Vec3 camera,
                                    float reach) {
    std::vector<RefractedPath> paths =
        RefractedConnections(surface, eta).find(x, {camera, Vec3(0), Rgb(1)});
    std::erase_if(paths, [&](const RefractedPath& path) { return path.inside > reach; });
    return paths;
}

TEST(ReferenceLinks, OfAMeshAreAllRefractedPaths) {
    const TriangleMesh mesh = test::bumpy_mesh(3);
    const Vec3 camera(14, 18, 25);
    constexpr float kReach = 6;
    std::size_t found = 0;
    for (float eta : {1.0f, 1.3f, 1.5f}) {
        const MeshBody body(mesh, double(eta), DVec3(camera), double(kReach), 4000);
        for (std::uint64_t i = 0; i < 300; ++i) {
            const Vec3 x = random_point(9, i);
            const std::vector<CameraLink> links = links_of(body, x, kReach);
            const std::vector<RefractedPath> paths = paths_of(mesh, eta, x, camera, kReach);
            ASSERT_EQ(links.size(), paths.size()) << "eta " << eta << ", point " << i;
            for (const CameraLink& link : links) {
                const auto same = std::ranges::min_element(paths, {}, [&](const auto& path) {
                    return glm::length(path.position - Vec3(link.position));
                });
                EXPECT_LT(glm::length(same->position - Vec3(link.position)), 1e-4f);
                EXPECT_NEAR(link.spread, double(same->spread), 1e-4 * link.spread);
                EXPECT_NEAR(link.inside, double(same->inside), 1e-4);
                EXPECT_NEAR(link.cos_out, double(glm::dot(same->w_i, same->n_g)), 1e-4);
                ++found;
            }
        }
    }
    EXPECT_GT(found, 200u);
}

TEST(ReferenceLinks, OfASphereAreTheRefractedPathsBeforeTheCaustic) {
    constexpr float kReach = 12, kRadius = 10, kEta = 1.5f;
    const Vec3 camera(-6, 8, 60);
    const SphereBody body(Vec3(0), kRadius, double(kEta), DVec3(camera));
    const Surface surface = SphereSurface{{glm::mat3(kRadius), Vec3(0)}};
    std::size_t found = 0;
    for (std::uint64_t i = 0; i < 400; ++i) {
        const Vec3 x = random_point(kRadius, i);
        const std::vector<RefractedPath> paths = paths_of(surface, kEta, x, camera, kReach);
        for (const CameraLink& link : links_of(body, x, kReach)) {
            const auto same = std::ranges::min_element(paths, {}, [&](const auto& path) {
                return glm::length(path.position - Vec3(link.position));
            });
            ASSERT_NE(same, paths.end());
            EXPECT_LT(glm::length(same->position - Vec3(link.position)), 2e-5f);
            EXPECT_NEAR(link.spread, double(same->spread), 1e-3 * link.spread);
            EXPECT_TRUE(body.links_path(x, Vec3(link.position), float(link.inside), kReach));
            EXPECT_FALSE(body.links_path(x, -Vec3(link.position), float(link.inside), kReach));
            ++found;
        }
        // Near the surface towards the camera nothing is left out.
        const bool near = glm::length(x) > 0.9f * kRadius && glm::dot(x, camera) > 300;
        EXPECT_TRUE(!near || links_of(body, x, kReach).size() == 1) << i;
    }
    EXPECT_GT(found, 100u);
}

TEST(ReferenceLinks, ClearnessKnowsTheBodyInTheWay) {
    const TriangleMesh mesh = test::bumpy_mesh(3);
    const DVec3 camera(14, 18, 25);
    const MeshBody body(mesh, 1.3, camera, 20, 4000);
    std::size_t clear = 0, blocked = 0;
    for (std::uint64_t i = 0; i < 400; ++i) {
        const Vec3 x = random_point(9, i);
        if (!body.holds(x)) continue;
        for (const CameraLink& link : links_of(body, x, 20)) {
            const bool is_clear = body.is_clear(x, link);
            // Stepwise along both pieces: inside the body before the surface, outside after it.
            bool expected = true;
            for (int k = 1; k < 400; ++k) {
                const double t = k / 400.0;
                expected &= body.holds(Vec3(DVec3(x) + 0.999 * t * link.inside * link.w));
                expected &=
                    !body.holds(Vec3(link.position + (camera - link.position) * (1e-3 + 0.5 * t)));
            }
            if (is_clear == expected) (expected ? clear : blocked) += 1;
            EXPECT_EQ(is_clear, expected) << i;
        }
    }
    EXPECT_GT(clear, 50u);
    EXPECT_GT(blocked, 5u);
}

TEST(ReferenceDistanceGrid, BoundsTheDistance) {
    const DistanceGrid grid(Cells({Vec3(-2), Vec3(2)}, 1000),
                            [](Vec3 x) { return 1.5f - glm::length(x); });
    float best = 0;
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const Vec3 x = random_point(1.9f, i);
        const float distance = 1.5f - glm::length(x), bound = grid.clearance(x);
        if (distance >= 0) {
            EXPECT_GE(bound, 0);
            EXPECT_LE(bound, distance + 1e-5f);
            best = std::max(best, bound);
        } else if (bound < 0) {
            EXPECT_LT(distance, 0);
        }
    }
    EXPECT_GT(best, 1);
    EXPECT_LT(grid.clearance(Vec3(3, 0, 0)), 0);
}

}  // namespace
}  // namespace tallow::reference
