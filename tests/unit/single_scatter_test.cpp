// SPDX-License-Identifier: Apache-2.0
#include "render/single_scatter.h"

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/scene/presets.h"
#include "tests/support/half_space.h"
#include "tests/support/scenes.h"

namespace tallow {
namespace {

using test::half_space_radiance, test::hit_at_origin, test::up_direction;

Rgb scattered(const ScatteringBody& body, Vec3 w_o, int steps, std::uint64_t seed) {
    return single_scatter(body, {hit_at_origin(), w_o, seed}, lone_steps(steps));
}

// Measured over 64 rays of 64 steps: 0.05 %.
TEST(SingleScatter, HalfSpaceUnderParallelLight) {
    const std::vector<Surface> surfaces = {PlaneSurface{Vec3(0), Vec3(0, 1, 0)}};
    const RayScene rays(surfaces);
    for (float eta : {1.0f, 1.3f, 1.5f})
        for (float g : {0.0f, 0.7f, -0.5f})
            for (float cos_i : {1.0f, 0.6f, 0.2f})
                for (float cos_o : {0.9f, 0.3f}) {
                    Medium medium = test::marble();
                    medium.eta = eta, medium.g = g;
                    const Vec3 to_light = up_direction(cos_i, 0.3f),
                               w_o = up_direction(cos_o, 2.0f);
                    const Scene scene = test::lit_scene({DirectionalLight{-to_light, Rgb(1)}});
                    Rgb mean_L;
                    for (std::uint64_t seed = 0; seed < 64; ++seed)
                        mean_L +=
                            scattered({scene, rays, surfaces[0], 0, medium}, w_o, 64, seed) / 64;
                    const Rgb expected = half_space_radiance(medium, to_light, w_o);
                    for (int c = 0; c < 3; ++c)
                        EXPECT_NEAR(mean_L[c], expected[c], 2e-3 * expected[c])
                            << "eta " << eta << " g " << g << " cos " << cos_i << ' ' << cos_o;
                }
}

// Channels whose densities differ by a factor of a million, marched along one ray.
TEST(SingleScatter, ChannelsOfVeryDifferentDensity) {
    Medium medium = test::marble();
    medium.sigma_s_prime = {1e-3f, 1, 1e3f};
    medium.sigma_a = {1e-4f, 0.1f, 1e2f};
    const std::vector<Surface> surfaces = {PlaneSurface{Vec3(0), Vec3(0, 1, 0)}};
    const RayScene rays(surfaces);
    const Vec3 to_light = up_direction(0.7f, 0), w_o = up_direction(0.8f, 1);
    const Scene scene = test::lit_scene({DirectionalLight{-to_light, Rgb(1)}});
    Rgb mean_L;
    for (std::uint64_t seed = 0; seed < 64; ++seed)
        mean_L += scattered({scene, rays, surfaces[0], 0, medium}, w_o, 64, seed) / 64;
    const Rgb expected = half_space_radiance(medium, to_light, w_o);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean_L[c], expected[c], 0.01 * expected[c]) << c;
}

// A slab is less than a half-space: light that would come from below its far side is missing.
TEST(SingleScatter, StopsWhereTheRayLeavesTheBody) {
    const float thickness = 0.4f;
    const glm::mat3 size(1e4f, 0, 0, 0, thickness, 0, 0, 0, 1e4f);
    const std::vector<Surface> surfaces = {cube_mesh({size, Vec3(0, -thickness / 2, 0)})};
    const RayScene rays(surfaces);
    Medium medium = test::marble();
    const Vec3 to_light(0, 1, 0), w_o(0, 1, 0);
    const Scene scene = test::lit_scene({DirectionalLight{-to_light, Rgb(1)}});
    Rgb mean_L;
    for (std::uint64_t seed = 0; seed < 16; ++seed)
        mean_L += scattered({scene, rays, surfaces[0], 0, medium}, w_o, 64, seed) / 16;
    const Rgb half_space = half_space_radiance(medium, to_light, w_o);
    for (int c = 0; c < 3; ++c) {
        const double share = 1 - std::exp(-2 * double(medium.sigma_t()[c]) * double(thickness));
        EXPECT_NEAR(mean_L[c], share * half_space[c], 5e-3 * half_space[c]);
    }
}

TEST(SingleScatter, ShadowsOutsideAndGroupScales) {
    const std::vector<Surface> surfaces = {PlaneSurface{Vec3(0), Vec3(0, 1, 0)},
                                           SphereSurface{{glm::mat3(2.0f), Vec3(0, 5, 0)}}};
    const Vec3 w_o = up_direction(0.5f, 1);
    Scene scene = test::lit_scene({DirectionalLight{{0, -1, 0}, Rgb(1)}});
    const RayScene shaded(surfaces), open({surfaces.data(), 1});
    const auto scatter = [&](const RayScene& rays) {
        return scattered({scene, rays, surfaces[0], 0, test::marble()}, w_o, 32, 1);
    };
    EXPECT_EQ(scatter(shaded), Rgb(0));
    const Rgb once = scatter(open);
    EXPECT_GT(once.r, 0);
    scene.groups[0].scale = {2, 1, 0};
    const Rgb scaled = scatter(open);
    EXPECT_NEAR(scaled.r, 2 * once.r, 1e-5f * once.r);
    EXPECT_EQ(scaled.b, 0);
}

// Light enters a bounded half-space only through its opening.
TEST(SingleScatter, OpeningOfAHalfSpace) {
    const std::vector<Surface> surfaces = {PlaneSurface{Vec3(100, 0, 0), Vec3(0, 1, 0), 10}};
    const RayScene rays(surfaces);
    const Scene scene = test::lit_scene({DirectionalLight{{0, -1, 0}, Rgb(1)}});
    EXPECT_EQ(scattered({scene, rays, surfaces[0], 0, test::marble()}, Vec3(0, 1, 0), 32, 1),
              Rgb(0));
}

TEST(SingleScatter, NoScatteringNoLight) {
    const std::vector<Surface> surfaces = {PlaneSurface{Vec3(0), Vec3(0, 1, 0)}};
    const RayScene rays(surfaces);
    Medium absorber = test::marble();
    absorber.sigma_s_prime = Rgb(0);
    const Scene scene = test::lit_scene({DirectionalLight{{0, -1, 0}, Rgb(1)}});
    EXPECT_EQ(scattered({scene, rays, surfaces[0], 0, absorber}, Vec3(0, 1, 0), 32, 1), Rgb(0));
}

/// Root of the mean square of relative errors of the march, over rays and channels.
double march_error(const Scene& scene, const Surface& surface, const Medium& medium, int steps) {
    const RayScene rays({&surface, 1});
    double squares = 0, sum = 0;
    constexpr std::uint64_t kRays = 8, kSeeds = 64;
    for (std::uint64_t ray = 0; ray < kRays; ++ray) {
        const Vec3 w_o = up_direction(0.15f + 0.1f * float(ray), 2.4f * float(ray));
        const auto march = [&](int count, std::uint64_t seed) {
            return scattered({scene, rays, surface, 0, medium}, w_o, count, seed);
        };
        const Rgb reference = march(2048, 1);
        for (std::uint64_t seed = 2; seed < 2 + kSeeds; ++seed) {
            const Rgb error = march(steps, seed) - reference;
            for (int c = 0; c < 3; ++c) {
                squares += double(error[c]) * double(error[c]) / (3 * kRays * kSeeds);
                sum += double(reference[c]) / (3 * kRays * kSeeds);
            }
        }
    }
    return std::sqrt(squares) / sum;
}

// Prints the table of the header.
TEST(SingleScatter, ErrorOfTheMarchFallsWithItsSteps) {
    const Surface plane = PlaneSurface{Vec3(0), Vec3(0, 1, 0)};
    const Surface ball = SphereSurface{{glm::mat3(5.0f), Vec3(0, -5, 0)}};
    const Scene sun = test::lit_scene({DirectionalLight{-up_direction(0.5f, 1), Rgb(1)}});
    const Scene lamp = test::lit_scene({test::ceiling(8, 10, Rgb(1))});
    fmt::print("steps    marble: plane   ball    lamp   skin1: plane   ball    lamp\n");
    std::vector<double> previous(6, 10);
    for (int steps : {1, 4, 16, 64}) {
        std::vector<double> errors;
        for (const char* name : {"marble", "skin1"}) {
            const Medium medium = find_preset(name)->medium;
            errors.push_back(march_error(sun, plane, medium, steps));
            errors.push_back(march_error(sun, ball, medium, steps));
            errors.push_back(march_error(lamp, ball, medium, steps));
        }
        fmt::print("{:5}         {:.5f}\n", steps, fmt::join(errors, " "));
        for (std::size_t i = 0; i < errors.size(); ++i)
            EXPECT_LT(errors[i], 0.8 * previous[i]);  // measured 0.7

        previous = errors;
    }
}

}  // namespace
}  // namespace tallow
