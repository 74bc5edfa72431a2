// SPDX-License-Identifier: Apache-2.0
// Light that passes bodies without being scattered, against plates, balls and furnaces.
#include "common/lighting/passage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/base/rng.h"
#include "common/lighting/cosine_direction.h"
#include "common/lighting/direct_light.h"
#include "common/lighting/light_paths.h"
#include "common/optics/fresnel.h"
#include "tests/support/ball_mesh.h"
#include "tests/support/scenes.h"
#include "tests/support/shapes.h"

namespace tallow {
namespace {

constexpr PassageLimits kAll{1e-9f, 60};
constexpr float kThickness = 2;

// kThickness thick, its faces perpendicular to z; so wide that hardly a ray meets its edge.
Surface plate_at(float z, float width = 4000) {
    return cube_mesh({glm::mat3(width, 0, 0, 0, width, 0, 0, 0, kThickness), Vec3(0, 0, z)});
}

/// Bodies of one medium, and what else a test puts in.
struct World {
    Scene scene;
    std::vector<Surface> surfaces;

    explicit World(const std::vector<LightShape>& lights) : scene(test::lit_scene(lights)) {}
    void add(const Material& material, const Surface& surface) {
        scene.objects.push_back({SphereShape{1}, std::uint32_t(scene.materials.size()), {}, ""});
        scene.materials.push_back(material);
        surfaces.push_back(surface);
    }
    void add_body(const Medium& medium, const Surface& surface) {
        SubsurfaceMaterial material;
        material.medium = medium;
        add({"body", material}, surface);
    }
};

std::vector<Passage> passages(const World& world, const Ray& ray, PassageLimits limits = kAll) {
    const RayScene rays(world.surfaces);
    std::vector<Passage> result;
    find_passages(world.scene, rays, *rays.intersect(ray), -ray.direction, limits, result);
    return result;
}

/// Shares of radiance that a plate lets through and throws back by its far face, all orders.
struct Plate {
    double through, back;
    Plate(double eta, double cos_o, double sigma_t) {
        const double cos_inside = std::sqrt(1 - (1 - cos_o * cos_o) / (eta * eta));
        const double R = fresnel_reflectance(eta, cos_o);
        const double a = std::exp(-sigma_t * double(kThickness) / cos_inside);
        through = (1 - R) * (1 - R) * a / (1 - R * R * a * a);
        back = through * R * a;
    }
};

// The sum over all reflections inside, for each face that light leaves by. Rays set out beside the
// surface by a share of the scene's size, so that it is not wide.
TEST(Passage, OfAPlateIsTheIncoherentSum) {
    for (const float sigma : {0.01f, 0.7f})
        for (const float cos_o : {1.0f, 0.6f, 0.1f}) {
            World world({});
            world.add_body({Rgb(sigma), Rgb(0), 0, 1.5f}, plate_at(0, 200));
            const Vec3 w(std::sqrt(1 - cos_o * cos_o), 0, -cos_o);
            double through = 0, back = 0;
            for (const Passage& p : passages(world, {Vec3(0.1f, 0.2f, 1) - 10.0f * w, w})) {
                const bool down = p.ray.direction.z < 0;
                (down ? through : back) += double(p.weight.g);
                const Vec3 expected(w.x, 0, down ? w.z : -w.z);
                EXPECT_LT(glm::length(p.ray.direction - expected), 1e-5f);
            }
            const Plate plate(1.5, double(cos_o), double(sigma));
            EXPECT_NEAR(through, plate.through, 1e-4 * plate.through + 1e-6) << sigma << cos_o;
            EXPECT_NEAR(back, plate.back, 1e-4 * plate.back + 1e-6) << sigma << cos_o;
        }
}

// Scattered forward is scattered: sigma_s + sigma_a counts, ten times sigma_s' here.
TEST(Passage, LosesWhatIsScattered) {
    World world({});
    world.add_body({Rgb(0), Rgb(0.02f, 0.05f, 0.1f), 0.9f, 1}, plate_at(0));
    const auto found = passages(world, {{0, 0, 10}, {0, 0, -1}});
    ASSERT_EQ(found.size(), 1u);
    for (int c = 0; c < 3; ++c) {
        const float sigma_s = Rgb(0.02f, 0.05f, 0.1f)[c] / (1 - 0.9f);
        EXPECT_NEAR(found[0].weight[c], std::exp(-sigma_s * kThickness), 1e-5);
    }
}

// A clear body takes nothing: what is mirrored and what passes is 1. The ball's rays meet its
// surface under the same angle each time; the cube's are reflected totally.
TEST(Passage, OfClearBodiesLosesNothing) {
    for (const Surface& shape :
         {test::ball(Vec3(0), 3), Surface(cube_mesh({glm::mat3(5.0f), Vec3(0)}))})
        for (const Vec3 target : {Vec3(0.3f, 0.2f, 0), Vec3(1.1f, 0.4f, 0.9f)}) {
            World world({});
            world.add_body({Rgb(1e-7f), Rgb(0), 0, 1.3f}, shape);
            const Vec3 eye(2, 5, 30), w = glm::normalize(target - eye);
            const RayScene rays(world.surfaces);
            const Hit hit = *rays.intersect({eye, w});
            double sum = fresnel_reflectance(1.3f, -glm::dot(w, hit.n));
            for (const Passage& p : passages(world, {eye, w})) sum += double(p.weight.g);
            EXPECT_NEAR(sum, 1, 1e-5);
        }
}

// Too weak is not followed, and half-spaces have no other side.
TEST(Passage, OfThickBodiesIsNone) {
    World thick({});
    thick.add_body({Rgb(1), Rgb(9), 0, 1.3f}, test::ball(Vec3(0), 3));
    EXPECT_TRUE(passages(thick, {{0, 0, 10}, {0, 0, -1}}, {1e-4f, 8}).empty());
    World half({});
    half.add_body({Rgb(1), Rgb(1), 0, 1.3f}, PlaneSurface{Vec3(0), {0, 0, 1}});
    EXPECT_TRUE(passages(half, {{0, 0, 10}, {0, 0, -1}}).empty());
}

struct MeanAndError {
    double mean, error;  // standard error
};

/// Irradiance by what paths bring back to a point, without the exitance of bodies.
MeanAndError irradiance(const World& world, Vec3 x, Vec3 n, int count) {
    const RayScene rays(world.surfaces);
    const LightPaths paths(world.scene, rays, 32);
    const Frame frame = make_frame(n);
    double sum = 0, squares = 0;
    for (int k = 0; k < count; ++k) {
        std::vector<Rgb> L(1);
        std::vector<BodyVertex> bodies;
        paths.follow(
            {rays.offset_origin(x, n, n), cosine_direction(frame, sobol_2d(std::uint32_t(k), 1))},
            0, mix_bits(std::uint64_t(k)), LightPaths::Collect::everything, L, bodies);
        const double E = std::numbers::pi * double(L[0].g);
        sum += E, squares += E * E;
    }
    const double mean = sum / count;
    return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean) / count)};
}

// Under a plate of glass that absorbs, the sky is as bright as the plate lets through.
TEST(PassingPaths, SkyThroughAPlate) {
    for (const float sigma : {1e-6f, 0.3f}) {
        World world({EnvironmentLight{Rgb(1)}});
        world.add_body({Rgb(sigma), Rgb(0), 0, 1.5f}, plate_at(5));
        world.add({"floor", DiffuseMaterial{Rgb(0)}}, PlaneSurface{Vec3(0), {0, 0, 1}});
        double expected = 0;
        constexpr int kSteps = 4000;
        for (int i = 0; i < kSteps; ++i) {
            const double mu = (i + 0.5) / kSteps;
            expected += 2 * std::numbers::pi * mu * Plate(1.5, mu, double(sigma)).through / kSteps;
        }
        const auto E = irradiance(world, Vec3(0), {0, 0, 1}, 1 << 12);
        // Measured: 2e-4 and less. What is cut off is below 1e-4 a reflection.
        EXPECT_NEAR(E.mean, expected, 1e-3 * expected) << sigma;
    }
}

// A clear ball above a white floor under a sky of radiance 1 vanishes: its shadow is filled by what
// passes it and by what it mirrors.
TEST(PassingPaths, ClearBallFillsItsShadow) {
    World world({EnvironmentLight{Rgb(1)}});
    world.add_body({Rgb(1e-7f), Rgb(0), 0, 1.5f}, test::ball({0.4f, 0, 3}, 2));
    world.add({"floor", DiffuseMaterial{Rgb(1)}}, PlaneSurface{Vec3(0), {0, 0, 1}});
    const Vec3 x(0), n(0, 0, 1);
    const RayScene rays(world.surfaces);
    std::vector<Rgb> direct(1);
    add_direct_light(world.scene, rays, {x, n, n, 1}, 1 << 14, {}, direct);
    const auto indirect = irradiance(world, x, n, 1 << 15);
    EXPECT_GT(indirect.mean, 1);  // of pi
    EXPECT_NEAR(double(direct[0].g) + indirect.mean, std::numbers::pi, 4 * indirect.error + 2e-3);
}

// A lamp behind a plate, met by chance: in expectation its direct irradiance times what passes.
TEST(PassingPaths, LampBehindAnAbsorbingPlate) {
    World world({SphereLight{{0, 0, 30}, 4, Rgb(10)}});
    world.add_body({Rgb(0.4f), Rgb(0), 0, 1.4f}, plate_at(5));
    const double sin2 = 16.0 / 900, mu = std::sqrt(1 - sin2 / 2);
    const double expected = 10 * std::numbers::pi * sin2 * Plate(1.4, mu, 0.4).through;
    const auto E = irradiance(world, Vec3(0), {0, 0, 1}, 1 << 18);
    // Seen through the plate it is nearer by (1 - 1 / eta) of the thickness: 4 % of E.
    const double nearer = std::pow(30 / (30 - double(kThickness) * (1 - 1 / 1.4)), 2);
    EXPECT_NEAR(E.mean, nearer * expected, 4 * E.error + 0.003 * expected);
    EXPECT_LT(E.error, 0.02 * expected);
}

// A body that light is told not to pass leaves its shadow black.
TEST(PassingPaths, EndAtBodiesWithoutTransmission) {
    World world({EnvironmentLight{Rgb(1)}});
    world.add_body({Rgb(0.01f), Rgb(0), 0, 1}, plate_at(5));
    world.add({"floor", DiffuseMaterial{Rgb(0)}}, PlaneSurface{Vec3(0), {0, 0, 1}});
    EXPECT_GT(irradiance(world, Vec3(0), {0, 0, 1}, 256).mean, 2.5);
    std::get<SubsurfaceMaterial>(world.scene.materials[0].kind).transmission = Switch::off;
    EXPECT_EQ(irradiance(world, Vec3(0), {0, 0, 1}, 256).mean, 0);
}

// Bodies behind bodies: a path that passes the first meets the second, and the same one whatever is
// collected.
TEST(PassingPaths, MeetBodiesBehindBodiesAlways) {
    World world({EnvironmentLight{Rgb(1)}});
    world.add_body({Rgb(0.05f), Rgb(0.05f), 0, 1.3f}, test::ball({0, 0, 5}, 2));
    world.add_body({Rgb(0.05f), Rgb(5), 0, 1.3f}, test::ball({0, 0, 10}, 2));
    const RayScene rays(world.surfaces);
    const LightPaths paths(world.scene, rays, 2);
    int behind = 0;
    constexpr int kCount = 400;
    for (std::uint64_t k = 0; k < kCount; ++k) {
        std::vector<BodyVertex> all, again;
        std::vector<Rgb> L(1), unused(1);
        const Ray ray{Vec3(0), {0, 0, 1}};
        paths.follow(ray, 0, mix_bits(k), LightPaths::Collect::everything, L, all);
        paths.follow(ray, 0, mix_bits(k), LightPaths::Collect::bodies, unused, again);
        ASSERT_EQ(all.size(), again.size());
        ASSERT_FALSE(all.empty());
        EXPECT_EQ(all[0].object, 0u);
        if (all.size() > 1 && all[1].object == 1) ++behind;
        for (std::size_t i = 0; i < all.size(); ++i) {
            EXPECT_EQ(all[i].position, again[i].position);
            EXPECT_EQ(all[i].factor, again[i].factor);
        }
        EXPECT_EQ(max_channel(unused[0]), 0);
    }
    // e^(-0.1 * 4) of the paths, less the Fresnel loss of 3.4 %: 0.648. Four standard deviations.
    const double R = fresnel_reflectance(1.3, 1.0), p = (1 - R) * (1 - R) * std::exp(-0.4);
    EXPECT_NEAR(behind / double(kCount), p, 4 * std::sqrt(p * (1 - p) / kCount));
}

}  // namespace
}  // namespace tallow
