// SPDX-License-Identifier: Apache-2.0
#include "precompute/choose_spacing.h"

#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "precompute/sample_surface.h"
#include "tests/support/ball_mesh.h"
#include "tests/support/error_text.h"
#include "tests/support/patch_meshes.h"
#include "tests/support/scenes.h"

namespace tallow {
namespace {

struct Bodies {
    Scene scene;
    SceneGeometry geometry;

    void add(Surface surface, const Medium& medium) {
        SubsurfaceMaterial material;
        material.medium = medium;
        scene.materials.push_back({"body", material});
        scene.objects.push_back(
            {SphereShape{1}, std::uint32_t(scene.materials.size() - 1), {}, "scene.yaml:7:5"});
        geometry.surfaces.push_back(std::move(surface));
    }

    std::vector<BodySpacing> choose(const SamplingWish& wish) const {
        return choose_spacings(scene, geometry,
                               std::vector<Treatment>(scene.objects.size(), Treatment::samples),
                               wish);
    }

    std::vector<double> sample(double points) const {
        std::vector<double> counts;
        for (const BodySpacing& body : choose({{}, points}))
            counts.push_back(
                double(sample_surface(geometry.surfaces[body.object], body.spacing).size()));
        return counts;
    }
};

Bodies body(Surface surface) {
    Bodies bodies;
    bodies.add(std::move(surface), test::marble());
    return bodies;
}

TEST(ChooseSpacing, MeetsAnyNumberOfPointsWithinFivePercent) {
    const std::pair<const char*, Surface> shapes[] = {
        {"cube", cube_mesh({glm::mat3(10.0f), Vec3(0)})},
        {"coarse ball", test::bumpy_mesh(2)},  // 128 triangles
        {"fine ball", test::bumpy_mesh(7)},    // 131 072
        {"needles", test::needle_mesh(300, 1, 50)},
        {"wire", test::needle_mesh(12, 0.05f, 100)},
        {"sphere", SphereSurface{{glm::mat3(3.0f), Vec3(1)}}},
        {"ellipsoid", SphereSurface{{glm::mat3(5, 0, 0, 1, 1, 0, 0, 0, 2), Vec3(0)}}},
        {"half-space", PlaneSurface{{0, 0, 0}, {0, 0, 1}, 20}}};
    for (const auto& [name, surface] : shapes)
        for (double points : {300.0, 1000.0, 1370.0, 9999.0, 54321.0, 400000.0}) {
            const double got = body(surface).sample(points)[0];
            EXPECT_NEAR(got, points, 0.05 * points) << name;
        }
}

// Numbers at which all twelve triangles of a cube could only be halved at once, if they were.
TEST(ChooseSpacing, MeetsNumbersThatTrianglesDoNotDivide) {
    for (double points : {20.0, 37.0, 50.0, 71.0})
        EXPECT_NEAR(body(cube_mesh({})).sample(points)[0], points, 0.05 * points + 1);
}

TEST(ChooseSpacing, BodiesShareThePointsAsTheAutomaticSpacingsWould) {
    Bodies bodies;
    bodies.add(SphereSurface{{glm::mat3(10.0f), Vec3(0)}}, test::marble());
    bodies.add(SphereSurface{{glm::mat3(10.0f), Vec3(30)}}, test::skim_milk());
    bodies.scene.materials.push_back({"floor", DiffuseMaterial{}});
    bodies.scene.objects.push_back({SphereShape{1}, 2, {}, "scene.yaml:9:5"});
    bodies.geometry.surfaces.push_back(SphereSurface{{glm::mat3(1.0f), Vec3(60)}});

    const std::vector<double> counts = bodies.sample(20000);
    ASSERT_EQ(counts.size(), 2u);  // the floor has none
    EXPECT_NEAR(counts[0] + counts[1], 20000, 1000);
    // Mean free paths 1 / 3.0071 and 1 / 1.9142 mm of the channel with the smallest.
    EXPECT_NEAR(counts[0] / counts[1], std::pow(3.0071 / 1.9142, 2), 0.1);
}

TEST(ChooseSpacing, TakesTheWishedSpacingForAllBodies) {
    for (const BodySpacing& chosen : body(cube_mesh({})).choose({0.125f, {}}))
        EXPECT_EQ(chosen.spacing, 0.125f);
}

TEST(ChooseSpacing, RefusesWhatNoMemoryHolds) {
    const std::string spacing = error_text<InputError>([] {
        return body(SphereSurface{{glm::mat3(1e3f), Vec3(0)}}).choose({1e-3f, {}});
    });
    EXPECT_TRUE(
        spacing.starts_with("scene.yaml:7:5: a spacing of 0.001 mm takes about 1.26e+13 "
                            "samples and "))
        << spacing;
    EXPECT_TRUE(spacing.ends_with("leaves; give a larger --spacing, or fewer --points")) << spacing;
    const std::string points = error_text<InputError>([] {
        return body(cube_mesh({})).choose({{}, 4e9});
    });
    EXPECT_TRUE(points.starts_with("scene.yaml:7:5: a spacing of ")) << points;
}

// Long thin triangles have far more pieces than area / spacing^2: that counts, too.
TEST(ChooseSpacing, RefusesTooManyPiecesOfNeedles) {
    const std::string text = error_text<InputError>([] {
        return body(test::needle_mesh(1000, 1e-6f, 1e5f)).choose({1e-3f, {}});
    });
    EXPECT_TRUE(text.starts_with("scene.yaml:7:5: a spacing of 0.001 mm takes about ")) << text;
}

TEST(ChooseSpacing, RefusesFewerPointsThanABodyHasSides) {
    EXPECT_EQ(error_text<InputError>([] {
                  return body(cube_mesh({})).choose({{}, 2});
              }),
              "scene.yaml:7:5: --points: expected a number of samples that this body can have, got "
              "2; the nearest are about 6");
}

}  // namespace
}  // namespace tallow
