// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "render/entry_directions.h"
#include "render/patch_gate.h"
#include "render/refraction_tree.h"
#include "render/single_scatter.h"
#include "tests/support/ball_mesh.h"
#include "tests/support/half_space.h"
#include "tests/support/scenes.h"

namespace tallow {
namespace {

using test::up_direction;

Vec3 even_direction(std::uint32_t i, std::uint32_t n) {
    constexpr float kGolden = 2.39996323f;
    const float z = 1 - (2 * float(i) + 1) / float(n), r = std::sqrt(1 - z * z);
    return {r * std::cos(kGolden * float(i)), r * std::sin(kGolden * float(i)), z};
}

std::vector<LightShape> lamps() {
    return {test::ceiling(25, 14, Rgb(1)), SphereLight{{8, 24, -9}, 5, Rgb(1)},
            DiscLight{{0, 25, 3}, {0, -1, 0}, 7, Rgb(1)}, EnvironmentLight{Rgb(1)}};
}

/// Mean over rays from all around the upper side of a body.
Rgb mean_radiance(const Surface& surface, const LightShape& light, LampPaths lamps, int steps) {
    Medium medium = test::marble();
    medium.sigma_s_prime = {0.2f, 0.5f, 1.5f}, medium.g = 0.3f, medium.eta = 1.4f;
    const std::vector<Surface> surfaces = {surface};
    const RayScene rays(surfaces);
    const RefractedConnections connections(surfaces[0], medium.eta);
    const Scene scene = test::lit_scene({light});
    ScatteringBody body{scene, rays, surfaces[0], 0, medium, &connections};
    body.lamps = lamps;
    constexpr int kRays = 24;
    Rgb sum;
    for (std::uint64_t k = 0; k < kRays; ++k) {
        const Vec3 w_o = up_direction(0.03f + 0.038f * float(k), 2 * float(k));
        const auto hit = rays.intersect({100.0f * w_o, -w_o});
        sum += single_scatter(body, {hit.value(), w_o, k}, lone_steps(steps)) / float(kRays);
    }
    return sum;
}

// Rays drawn from the places against the search for paths to points of lamps, its slow twin.
// Measured: within 3.6 %, of noise.
TEST(DrawnSingleScatter, AgreesWithTheSearch) {
    for (const bool smooth : {false, true}) {
        const TriangleMesh mesh = test::bumpy_mesh(4);
        const Surface surface = smooth ? test::smoothed(mesh) : mesh;
        for (const LightShape& light : lamps()) {
            const Rgb searched = mean_radiance(surface, light, LampPaths::searched, 1024);
            const Rgb drawn = mean_radiance(surface, light, LampPaths::drawn, 2048);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(drawn[c], searched[c], 0.05f * searched[c])
                    << smooth << ' ' << light.index() << ' ' << c;
        }
    }
}

TEST(DrawnSingleScatter, AnEvenSkyAloneIsDrawn) {
    const Surface surface = test::bumpy_mesh(3);
    const auto of = [&](const LightShape& light, LampPaths paths) {
        return mean_radiance(surface, light, paths, 16);
    };
    const LightShape sky = EnvironmentLight{Rgb(1)}, quad = test::ceiling(25, 14, Rgb(1));
    EXPECT_EQ(of(sky, LampPaths::sky_drawn), of(sky, LampPaths::drawn));
    EXPECT_EQ(of(quad, LampPaths::sky_drawn), of(quad, LampPaths::searched));
}

// The density is that of the directions that are drawn: it integrates to the part of draws that
// give one. Quadrature on 200,000 directions; measured: 2e-3.
TEST(EntryDirections, DensityIsThatOfTheDraws) {
    const Vec3 x(0.3f, -0.5f, 0.2f);
    for (const LightShape& shape : lamps()) {
        const Light light{shape};
        EntryDirections directions(light, bounding_ball(light), x, 1.4f);
        directions.add(up_direction(0.9f, 1), 2);
        directions.add(up_direction(0.3f, 4), 1);
        constexpr std::uint32_t kDraws = 4096, kDirections = 200000;
        int drawn = 0;
        for (std::uint32_t i = 0; i < kDraws; ++i)
            if (const auto w = directions.draw(sobol_2d(i, 7))) {
                ++drawn;
                EXPECT_GT(directions.density(*w), 0);
            }
        double integral = 0;
        for (std::uint32_t i = 0; i < kDirections; ++i)
            integral += double(directions.density(even_direction(i, kDirections)));
        EXPECT_NEAR(integral * 4 * double(kPi) / kDirections, double(drawn) / kDraws, 5e-3)
            << shape.index();
    }
}

// The gate passes what its scalar twin passes. Where rounding decides they may differ; measured: 0
// of 12,800.
TEST(PatchGate, PassesWhatRefractionCullPasses) {
    const TriangleMesh mesh = test::smoothed(test::bumpy_mesh(3));
    int differ = 0, passed = 0;
    for (std::uint32_t round = 0; round < 50; ++round) {
        BeamQueries queries(1.4);
        std::vector<RefractionCull> culls;
        const auto random = [&](std::uint32_t i, std::uint32_t k) {
            return to_unit_float(random_bits(round, k, i)) - 0.5f;
        };
        for (std::uint32_t i = 0; i < BeamQueries::kMost; ++i) {
            const Vec3 x(16 * random(i, 0), 16 * random(i, 1), 16 * random(i, 2));
            const Vec3 y(60 * random(i, 3), 60 * random(i, 4), 60 * random(i, 5));
            const bool far = round % 2 == 0;
            const Ends ends{DVec3(x), far ? glm::normalize(DVec3(y)) : DVec3(y), far, 1.4};
            const float reach = 8 + 8 * random(i, 6);
            queries.set(i, ends, reach);
            culls.emplace_back(ends, reach);
        }
        for (std::uint32_t t = 0; t < 16; ++t) {
            const std::uint32_t triangle = (round * 16 + t) % std::uint32_t(mesh.triangles.size());
            const PatchBound bound = bound_triangles(mesh, &triangle, &triangle + 1);
            const std::uint32_t bits = may_refract(bound, queries);
            for (std::uint32_t i = 0; i < BeamQueries::kMost; ++i) {
                const bool passes = (bits >> i & 1) != 0;
                differ += passes != culls[i].may_refract(bound) ? 1 : 0;
                passed += passes ? 1 : 0;
            }
        }
    }
    EXPECT_GT(passed, 100);
    EXPECT_LE(differ, 12);
}

}  // namespace
}  // namespace tallow
