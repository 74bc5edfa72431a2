// SPDX-License-Identifier: Apache-2.0
// What is prepared once serves any picture: the same bytes as if it were prepared for each.
#include "render/prepared_scene.h"

#include <gtest/gtest.h>

#include "precompute/precompute.h"
#include "render/render_image.h"
#include "tests/support/scene_text.h"
#include "tests/support/test_files.h"

namespace tallow {
namespace {

constexpr const char* kScene = R"(
cameras:
  main: {type: perspective, position: [3, 3, 7], look_at: [0, 0, 0], fov_deg: 30, resolution: [16, 12], turntable: {frames: 5}}
  lens: {type: thin-lens, position: [-3, 3, 7], look_at: [0, 0, 0], fov_deg: 30, resolution: [12, 16], aperture_mm: 1, focus_mm: 7}
materials:
  wax: {type: subsurface, sigma_s_prime: [1, 1.5, 2], sigma_a: [0.02, 0.1, 0.3], eta: 1.4}
  floor: {type: diffuse, reflectance: 0.4}
objects:
  - {shape: cube, size: [3, 2, 2], material: wax}
  - {shape: plane, point: [0, -1.5, 0], normal: [0, 1, 0], material: floor}
lights:
  - {type: quad, position: [0, 6, -3], look_at: [0, 0, 0], size: [2, 2], radiance: 9, group: key}
  - {type: point, position: [5, 6, 3], intensity: 40, group: fill}
settings: {samples: 2, light_samples: 4, bounces: 0}
)";

class PreparedSceneTest : public ::testing::Test {
protected:
    PreparedSceneTest() {
        const std::filesystem::path file = fresh_folder() / "scene.tallow";
        Progress quiet(true);
        precompute(scene_, {{0.4f, {}}}, file, quiet, stats_);
        cache_.emplace(file);
    }

    std::unique_ptr<PreparedScene> prepare(const Scene& scene) {
        return std::make_unique<PreparedScene>(scene, geometry_, cache_->view(), ExitanceAccuracy{},
                                               no_diffuse_, stats_);
    }

    std::vector<std::vector<float>> render(const PreparedScene& world, const Camera& camera) {
        Progress quiet(true);
        const Image image = render_image(
            world, camera, {whole_image(camera), 2, {"multiple", "single"}}, quiet, stats_);
        std::vector<std::vector<float>> values;
        for (const Channel& channel : image.channels) values.push_back(channel.values);
        return values;
    }

    const Scene scene_ = scene_of(kScene);
    Stats stats_;
    const SceneGeometry geometry_ = load_geometry(scene_, stats_);
    const std::vector<std::optional<Rgb>> no_diffuse_;
    std::optional<MappedCache> cache_;
};

TEST_F(PreparedSceneTest, PicturesDoNotDependOnThoseBefore) {
    const auto world = prepare(scene_);
    const Camera turned = camera_at(scene_.cameras[0], 3);
    const auto first = render(*world, scene_.cameras[0]), second = render(*world, turned);
    EXPECT_NE(first, second);
    render(*world, scene_.cameras[1]);
    EXPECT_EQ(render(*world, scene_.cameras[0]), first);
    EXPECT_EQ(render(*prepare(scene_), turned), second);
}

// Scales of groups, one of them 0; a medium; a colour; all together, and back again.
TEST_F(PreparedSceneTest, ChangesAreAsGoodAsPreparingAgain) {
    const auto world = prepare(scene_);
    const Camera& camera = scene_.cameras[0];
    const auto before = render(*world, camera);
    const std::string dim = "groups={key: {scale: [2, 1, 0.5]}, fill: {scale: 0}}",
                      medium = "materials.wax.sigma_a=[0.3, 0.1, 0.02]",
                      model = "materials.wax.model=better-dipole",
                      straight = "materials.wax.single_scattering=straight",
                      colour = "materials.floor.reflectance=[0.8, 0.1, 0.1]";
    for (const std::vector<std::string>& overrides :
         std::vector<std::vector<std::string>>{{dim},
                                               {medium},
                                               {model},
                                               {straight},
                                               {straight, dim},
                                               {colour},
                                               {dim, medium, model, colour}}) {
        const Scene other = scene_of(kScene, overrides);
        world->change(other, {}, no_diffuse_, stats_);
        const auto changed = render(*world, camera);
        EXPECT_NE(changed, before) << overrides.front();
        EXPECT_EQ(changed, render(*prepare(other), camera)) << overrides.front();
    }
    world->change(scene_, {}, no_diffuse_, stats_);
    EXPECT_EQ(render(*world, camera), before);
}

// Diffusion in the body is kept for each light group: the same bytes, whichever groups were lit
// before.
TEST_F(PreparedSceneTest, ScalesOfGroupsNeedNoSolve) {
    const std::string body_aware =
        "materials.wax={type: subsurface, model: body-aware, sigma_s_prime: [1, 1.5, 2], "
        "sigma_a: [0.02, 0.1, 0.3], eta: 1.4}";
    const Camera& camera = scene_.cameras[0];
    const auto with = [&](const std::string& groups) {
        return scene_of(kScene, {body_aware, "groups=" + groups});
    };
    const auto world = prepare(with("{key: {scale: 1}, fill: {scale: 0}}"));
    ASSERT_GT(world->body(0)->exitance_of.clusters(), 0u);
    ASSERT_TRUE(world->body(0)->diffusion.of_group[0]);
    EXPECT_FALSE(world->body(0)->diffusion.of_group[1]);  // in the dark so far
    const float* kept = &world->body(0)->diffusion.of_group[0]->fine.B[0].r;
    for (const std::string groups :
         {"{key: {scale: [2, 1, 0.5]}, fill: {scale: 3}}", "{key: {scale: 0}, fill: {scale: 1}}"}) {
        world->change(with(groups), {}, no_diffuse_, stats_);
        EXPECT_EQ(&world->body(0)->diffusion.of_group[0]->fine.B[0].r, kept);
        EXPECT_TRUE(world->body(0)->diffusion.of_group[1]);
        EXPECT_EQ(render(*world, camera), render(*prepare(with(groups)), camera)) << groups;
    }
    // Another medium is another solve.
    world->change(scene_of(kScene, {body_aware, "materials.wax.eta=1.4",
                                    "materials.wax.sigma_a=[0.3, 0.1, 0.02]"}),
                  {}, no_diffuse_, stats_);
    EXPECT_NE(&world->body(0)->diffusion.of_group[0]->fine.B[0].r, kept);
}

// What became of the solve is in the summary.
TEST_F(PreparedSceneTest, ReportsDiffusion) {
    const Scene scene = scene_of(
        kScene, {"materials.wax.model=body-aware", "materials.wax.sigma_s_prime=[1, 1, 90]"});
    stats_ = {};
    const auto world = prepare(scene);
    EXPECT_GT(std::get<std::int64_t>(stats_.counts.at("clusters")), 0);
    EXPECT_GT(std::get<std::int64_t>(stats_.counts.at("diffusion_iterations")), 0);
    EXPECT_GT(std::get<double>(stats_.errors.at("objects[0].diffusion")), 0);
    EXPECT_EQ(std::get<std::int64_t>(stats_.errors.at("objects[0].diffusion_converged")), 1);
    EXPECT_GT(stats_.seconds.at("diffusion"), 0);
    std::map<std::string, bool> computed;
    for (const Decision& decision : stats_.plan.decisions)
        computed[decision.term] = decision.computed;
    EXPECT_TRUE(computed.at("diffusion in the body, red"));
    EXPECT_FALSE(computed.at("diffusion in the body, blue"));  // samples do not resolve it
}

TEST(DiffusionWarning, NamesWhatMissesTheTolerance) {
    DiffusionReport report{true, 1234, {true, true, true}, 20, true, 0.019};
    EXPECT_EQ(diffusion_warning(report, 0.01), "");
    report.error = 0.031;
    EXPECT_EQ(diffusion_warning(report, 0.01),
              "diffusion on 1234 boundary elements is off by about 0.031 of the light, above the "
              "tolerance of 0.01: a smaller settings.tolerance takes more of them");
    report.converged = false;
    EXPECT_EQ(diffusion_warning(report, 0.01),
              "diffusion on 1234 boundary elements did not converge");
    EXPECT_EQ(diffusion_warning({}, 0.01), "");
}

// A cache may hold samples of a body that is taken for a diffuse surface now: they must not add to
// it. With indirect light, which a diffuse surface gathers for itself.
TEST_F(PreparedSceneTest, BodiesTakenForDiffuseSurfacesNeedNoSamples) {
    const Scene scene = scene_of(kScene, {"settings.bounces=1"});
    const std::vector<std::optional<Rgb>> diffuse = {Rgb(0.5f), std::nullopt};
    const PreparedScene with(scene, geometry_, cache_->view(), {}, diffuse, stats_);
    const PreparedScene without(scene, geometry_, {}, {}, diffuse, stats_);
    EXPECT_EQ(with.body(0), nullptr);
    EXPECT_EQ(render(with, scene.cameras[0]), render(without, scene.cameras[0]));
}

// Counts are those of all pictures.
TEST_F(PreparedSceneTest, CountsAddUp) {
    const auto world = prepare(scene_);
    stats_.counts.clear();
    render(*world, scene_.cameras[0]);
    EXPECT_EQ(std::get<std::int64_t>(stats_.counts.at("camera_rays")), 2 * 16 * 12);
    render(*world, scene_.cameras[1]);
    EXPECT_EQ(std::get<std::int64_t>(stats_.counts.at("camera_rays")), 2 * 2 * 16 * 12);
}

}  // namespace
}  // namespace tallow
