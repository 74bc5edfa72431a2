// SPDX-License-Identifier: Apache-2.0
// Frames of the viewer: drafts, passes, pictures of them, cameras as text.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "common/base/errors.h"
#include "common/image/png_io.h"
#include "precompute/precompute.h"
#include "render/render_image.h"
#include "tests/support/scene_text.h"
#include "tests/support/test_files.h"
#include "viewer/camera_text.h"
#include "viewer/frame_renderer.h"
#include "viewer/picture.h"
#include "viewer/screenshot.h"

namespace tallow {
namespace {

const std::string kScene = R"(
cameras:
  main: {type: perspective, position: [3, 3, 7], look_at: [0, 0, 0], fov_deg: 30, resolution: [50, 40]}
materials:
  wax: {type: subsurface, sigma_s_prime: [1, 1.5, 2], sigma_a: [0.02, 0.1, 0.3], eta: 1.4, boundary_elements: off}
  floor: {type: diffuse, reflectance: 0.4}
objects:
  - {shape: cube, size: [3, 2, 2], material: wax}
  - {shape: plane, point: [0, -1.5, 0], normal: [0, 1, 0], material: floor}
lights:
  - {type: quad, position: [0, 6, -3], look_at: [0, 0, 0], size: [2, 2], radiance: 9, group: key}
  - {type: point, position: [5, 6, 3], intensity: 40, group: fill}
settings: {samples: 4, light_samples: 4, indirect_samples: 4, bounces: 1, tolerance: 0.1, single_scattering_depths: 8}
)";

class Frames : public ::testing::Test {
protected:
    Frames() { viewed_ = load(); }

    std::unique_ptr<ViewedScene> load() {
        return std::make_unique<ViewedScene>(scene_, wish_, folder_ / "scene.tallow", quiet_,
                                             stats_);
    }
    ViewFrame rest(const PreparedScene& world, int samples = 4) {
        ProgressiveImage image(world, camera_, samples, {});
        while (!image.finished()) image.add_pass();
        return image.frame();
    }
    Image rendered(const PreparedScene& world, int samples = 4) {
        return render_image(world, camera_,
                            {whole_image(camera_),
                             samples,
                             {"multiple", "single", "diffuse", "specular", "exitance", "Z"},
                             {}},
                            quiet_, stats_);
    }
    FrameRenderer::Wish wish() const { return {camera_, wish_, 4}; }

    const std::filesystem::path folder_ = fresh_folder();
    const Scene scene_ = scene_of(kScene);
    const Camera camera_ = scene_.cameras[0];
    const SceneWish wish_ = ViewState(scene_, 0.01f).wish();
    Progress quiet_{true};
    Stats stats_;
    std::unique_ptr<ViewedScene> viewed_;
};

/// relRMSE of a channel.
double difference(const Image& a, const Image& b, const std::string& channel) {
    const auto &x = *a.find_channel(channel), &y = *b.find_channel(channel);
    double squares = 0, sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        squares += double(x[i] - y[i]) * double(x[i] - y[i]), sum += y[i];
    return std::sqrt(squares * double(x.size())) / sum;
}

// The same rays, one by one: only the sums are cut elsewhere, for which each has its tolerance.
TEST_F(Frames, PassesAddUpToThePictureOfTheRenderer) {
    const Image passes = frame_image(rest(viewed_->world()));
    const Image whole = rendered(viewed_->world());
    for (const char* channel : {"R", "G", "B", "multiple.R", "exitance.B"})
        EXPECT_LT(difference(passes, whole, channel), 0.01) << channel;  // measured 0.0013 at most
    for (const char* channel : {"A", "Z", "single.G"})  // no sums over samples in them
        EXPECT_LT(difference(passes, whole, channel), 1e-5) << channel;
}

TEST_F(Frames, EarlyPassesAreAsBright) {
    ProgressiveImage image(viewed_->world(), camera_, 64, {});
    image.add_pass();
    const ViewFrame first = image.frame();
    EXPECT_EQ(first.samples, 1);
    EXPECT_FALSE(first.finished());
    EXPECT_GT(first.shading_points, 0);
    double sum = 0, expected = 0;
    const Image a = frame_image(first), b = rendered(viewed_->world(), 64);
    for (const float x : *a.find_channel("G")) sum += x;
    for (const float x : *b.find_channel("G")) expected += x;
    EXPECT_NEAR(sum / expected, 1, 0.03);  // measured 1.1 % off, by single scattering's noise
}

TEST_F(Frames, DraftsLeaveSingleScatteringToTheRest) {
    const auto draft = draw_draft(viewed_->world(), camera_, 1, {});
    ASSERT_TRUE(draft);
    EXPECT_TRUE(draft->draft);
    const Image image = frame_image(*draft), whole = rendered(viewed_->world(), 1);
    for (const float x : *image.find_channel("single.G")) ASSERT_EQ(x, 0);
    EXPECT_EQ(*image.find_channel("Z"), *whole.find_channel("Z"));
    EXPECT_LT(difference(image, whole, "multiple.G"), 1e-6);  // the same points
    const auto coarse = draw_draft(viewed_->world(), camera_, 4, {});
    EXPECT_EQ(coarse->camera.width, 13);  // 50 / 4, rounded
    EXPECT_EQ(coarse->camera.height, 10);
    EXPECT_EQ(coarse->scale, 4);
}

// In blocks of 2 x 2 pixels, and as bright as the whole: a draft's light is that of one ray.
TEST_F(Frames, DraftsShareLightAmongNeighbours) {
    const auto draft = draw_draft(viewed_->world(), camera_, 1, {});
    const Image image = frame_image(*draft), whole = rendered(viewed_->world(), 64);
    const auto &diffuse = *image.find_channel("diffuse.G"),
               &mirrored = *image.find_channel("specular.G");
    const auto& z = *image.find_channel("P.Y");
    int same = 0, blocks = 0;
    for (int y = 0; y < 40; y += 2)
        for (int x = 0; x < 50; x += 2) {
            const auto at = [&](int i) { return std::size_t((y + i / 2) * 50 + x + i % 2); };
            if (!(z[at(0)] < -1.4f && z[at(3)] < -1.4f && z[at(1)] < -1.4f && z[at(2)] < -1.4f))
                continue;  // the floor
            ++blocks;
            same += diffuse[at(0)] == diffuse[at(3)] && diffuse[at(1)] == diffuse[at(2)];
        }
    EXPECT_GT(blocks, 50);
    EXPECT_EQ(same, blocks);
    double sum = 0, expected = 0, in_mirrors = 0, expected_in_mirrors = 0;
    for (std::size_t i = 0; i < diffuse.size(); ++i) {
        sum += diffuse[i], expected += (*whole.find_channel("diffuse.G"))[i];
        in_mirrors += mirrored[i], expected_in_mirrors += (*whole.find_channel("specular.G"))[i];
    }
    EXPECT_NEAR(sum / expected, 1, 0.2);
    EXPECT_NEAR(in_mirrors / expected_in_mirrors, 1, 0.2);
}

TEST_F(Frames, StopWhenTheyAreTold) {
    std::stop_source stop;
    stop.request_stop();
    ProgressiveImage image(viewed_->world(), camera_, 4, stop.get_token());
    EXPECT_FALSE(image.add_pass());
    EXPECT_FALSE(draw_draft(viewed_->world(), camera_, 1, stop.get_token()));
}

TEST_F(Frames, BoundsAreThereOnlyIfCertified) {
    EXPECT_EQ(rest(viewed_->world(), 1).largest_bound, 0);
    SceneWish certified = wish_;
    certified.certified = true;
    viewed_->show(certified);
    const ViewFrame frame = rest(viewed_->world(), 1);
    EXPECT_TRUE(frame.certified);
    EXPECT_GT(frame.largest_bound, 0);
    EXPECT_NE(frame_image(frame).find_channel("error_bound.R"), nullptr);
}

TEST_F(Frames, ChangesAreThoseOfAFreshScene) {
    SceneWish wish = wish_;
    wish.group_stops[0] = 1;
    wish.materials[0].preset = 3;
    wish.tolerance = 0.02f;
    viewed_->show(wish);
    const Image changed = rendered(viewed_->world());
    const ViewedScene fresh(scene_, wish, folder_ / "scene.tallow", quiet_, stats_);
    EXPECT_EQ(rendered(fresh.world()).channels[0].values, changed.channels[0].values);
    viewed_->show(wish_);
    EXPECT_EQ(rendered(viewed_->world()).channels[0].values,
              rendered(load()->world()).channels[0].values);
}

// The caches are those of tallow-precompute, and made once.
TEST_F(Frames, CachesAreMadeWhereTheyAreMissingOrStale) {
    const auto file = folder_ / "scene.tallow", other = folder_ / "other.tallow";
    const auto made = std::filesystem::last_write_time(file);
    precompute(scene_, {}, other, quiet_, stats_);
    EXPECT_EQ(read_bytes(file), read_bytes(other));
    load();
    EXPECT_EQ(std::filesystem::last_write_time(file), made);
    const Scene moved = scene_of(kScene, {"lights.0.position=[1, 6, -3]"});
    const ViewedScene stale(moved, wish_, file, quiet_, stats_);
    EXPECT_NE(read_bytes(file), read_bytes(other));
    write_bytes(file, "no cache");
    EXPECT_THROW(load(), InputError);
    EXPECT_EQ(read_bytes(file), "no cache");
}

/// Waits until something holds of the frames of a renderer.
template <class Condition>
bool wait_for(const Condition& condition) {
    for (int i = 0; i < 6000; ++i) {
        if (condition()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
}

TEST_F(Frames, RendererComesToRestWithTheWholePicture) {
    std::atomic<int> news{0};
    FrameRenderer renderer([this] { return load(); }, wish(), 2, [&] { ++news; });
    ASSERT_TRUE(wait_for([&] { return renderer.status().stage == FrameRenderer::Stage::resting; }));
    const FrameRenderer::News last = renderer.latest();
    EXPECT_TRUE(last.frame->finished());
    EXPECT_GT(news, 4);
    EXPECT_EQ(frame_image(*last.frame).channels[0].values,
              frame_image(rest(viewed_->world())).channels[0].values);
    EXPECT_TRUE(renderer.point_under(camera_, {25, 20}));
}

TEST_F(Frames, RendererTakesNewWishesAndKeepsOldFrames) {
    FrameRenderer renderer([this] { return load(); }, wish(), 2, [] {});
    Camera camera = camera_;
    FrameRenderer::Wish next = wish();
    for (int i = 0; i < 20; ++i) {
        camera.position.x += 0.05f;
        next.camera = camera;
        next.scene.group_stops[0] = float(i % 2);
        renderer.want(next);
        std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
    const auto shows = [&](Vec3 position) {
        const auto frame = renderer.latest().frame;
        return frame && frame->finished() && frame->camera.position == position;
    };
    EXPECT_TRUE(wait_for([&] { return shows(camera.position); }));

    next.camera.position = Vec3(0.1f);  // inside the cube
    renderer.want(next);
    ASSERT_TRUE(wait_for([&] { return !renderer.status().problem.empty(); }));
    EXPECT_NE(renderer.status().problem.find("inside this translucent body"), std::string::npos);
    EXPECT_TRUE(shows(camera.position));
    next.camera = camera_;
    renderer.want(next);
    EXPECT_TRUE(wait_for([&] { return shows(camera_.position); }));
    EXPECT_EQ(renderer.status().problem, "");
}

TEST_F(Frames, RendererHandsOverWhatEndedIt) {
    FrameRenderer renderer([]() -> std::unique_ptr<ViewedScene> { throw InputError("no mesh"); },
                           wish(), 1, [] {});
    EXPECT_TRUE(wait_for([&] {
        try {
            renderer.rethrow_failure();
        } catch (const InputError&) {
            return true;
        }
        return false;
    }));
}

TEST_F(Frames, PicturesDifferByAovAndExposure) {
    ViewFrame frame = rest(viewed_->world());
    const auto picture = [&](Aov aov, float stops) { return make_picture(frame, aov, stops).rgb; };
    std::vector<std::vector<std::uint8_t>> all;
    for (const Aov aov : {Aov::beauty, Aov::multiple, Aov::single, Aov::specular, Aov::exitance,
                          Aov::error, Aov::evaluations})
        all.push_back(picture(aov, 0));
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) EXPECT_NE(all[i], all[j]) << i << ' ' << j;
    EXPECT_NE(picture(Aov::beauty, 1), all[0]);
    EXPECT_EQ(picture(Aov::evaluations, 1), all[6]);
}

// The table is as good as the curve: a level at most, where rounding is close.
TEST_F(Frames, PicturesAreThoseOfThePngWriter) {
    const ViewFrame frame = rest(viewed_->world());
    const Picture picture = make_picture(frame, Aov::beauty, 0.5f);
    for (const TilePixels& tile : frame.tiles)
        for (std::size_t i = 0; i < tile.pixels.size(); ++i) {
            const int x = tile.tile.x0 + int(i) % tile.tile.width();
            const int y = tile.tile.y0 + int(i) / tile.tile.width();
            const Rgb display = tone_map(std::exp2(0.5f) * tile.pixels[i].radiance());
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(picture.rgb[std::size_t(3 * (y * 50 + x) + c)],
                            255 * srgb_encode(display[c]), 0.8);
        }
}

TEST_F(Frames, CamerasCanBePastedIntoTheScene) {
    for (const std::string unit : {"mm", "cm"}) {
        const Scene scene = scene_of("unit: " + unit + "\n" + kScene);
        Camera camera = scene.cameras[0];
        camera.position = {3.1234567f, -2.5e-3f, 17.25f};
        camera.look_at += Vec3(0.125f, 1.0f / 3, 0);
        camera.width = 123;
        for (const float lens : {0.0f, 0.7f}) {
            camera.lens_radius = lens;
            camera.focus = lens * 11;
            const std::string text = camera_text(scene, camera, "view_0001");
            std::string pasted = "unit: " + unit + "\n" + kScene;
            pasted.insert(pasted.find("  main:"), text.substr(text.find('\n') + 1));
            const Camera again = scene_of(pasted).cameras[0];
            EXPECT_EQ(again.name, "view_0001");
            EXPECT_LT(glm::distance(again.position, camera.position), 1e-5);
            EXPECT_LT(glm::distance(again.look_at, camera.look_at), 1e-5);
            EXPECT_EQ(again.up, camera.up);
            EXPECT_NEAR(again.fov, camera.fov, 1e-6);
            EXPECT_EQ(again.width, 123);
            EXPECT_FLOAT_EQ(again.lens_radius, lens);
            EXPECT_FLOAT_EQ(again.focus, camera.focus);
            if (unit == "mm") {
                EXPECT_EQ(again.position, camera.position);
            }
        }
        // On its own it is a section.
        EXPECT_NO_THROW(scene_of(camera_text(scene, camera, "view_0001")));
    }
}

// Far from its file's origin a scene has another one inside.
TEST(CameraText, IsAboutTheOriginOfTheFile) {
    Scene scene = scene_of(kScene);
    scene.origin = {1e6, 0, -2};
    const Camera camera = scene.cameras[0];
    EXPECT_NE(camera_text(scene, camera, "a").find("position: [1000003, 3, 5]"), std::string::npos)
        << camera_text(scene, camera, "a");
}

TEST_F(Frames, ScreenshotsGetFreeNames) {
    const ViewState state(scene_, 0.01f);
    const ViewFrame frame = rest(viewed_->world(), 1);
    write_bytes(folder_ / "scene_0001.exr", "");
    EXPECT_EQ(save_screenshot(folder_, scene_, frame, state, {}), folder_ / "scene_0002");
    EXPECT_EQ(save_screenshot(folder_, scene_, frame, state, {}), folder_ / "scene_0003");
    for (const char* extension : {".png", ".exr", ".yaml"})
        EXPECT_TRUE(std::filesystem::exists(folder_ / (std::string("scene_0002") + extension)));
    EXPECT_THROW(save_screenshot(folder_ / "none", scene_, frame, state, {}), OutputError);
}

}  // namespace
}  // namespace tallow
