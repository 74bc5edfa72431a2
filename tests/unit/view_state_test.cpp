// SPDX-License-Identifier: Apache-2.0
#include "viewer/view_state.h"

#include <gtest/gtest.h>

#include "common/scene/presets.h"
#include "tests/support/scene_text.h"

namespace tallow {
namespace {

const Scene kScene = scene_of(kCamera + R"(
materials:
  wax: {type: subsurface, sigma_s_prime: [1, 1.5, 2], sigma_a: [0.02, 0.1, 0.3], eta: 1.4}
  floor: {type: diffuse, reflectance: 0.4}
  stone: {type: subsurface, preset: marble, model: body-aware}
objects:
  - {shape: cube, size: 1, material: wax}
  - {shape: sphere, center: [3, 0, 0], radius: 1, material: stone}
lights:
  - {type: point, position: [5, 6, 3], intensity: 40, group: key}
  - {type: point, position: [5, 6, 3], intensity: 40, group: fill}
groups: {key: {scale: [1, 2, 3]}}
)");

class State : public ::testing::Test {
protected:
    void press(Key key) {
        state_.handle(KeyEvent{key, true});
        state_.handle(KeyEvent{key, false});
    }
    void press_with(Key held, Key key) {
        state_.handle(KeyEvent{held, true});
        press(key);
        state_.handle(KeyEvent{held, false});
    }
    Scene shown() const { return changed_scene(kScene, state_.wish()); }
    const SubsurfaceMaterial& body(const Scene& scene, int index) const {
        return std::get<SubsurfaceMaterial>(scene.materials[std::size_t(index)].kind);
    }

    ViewState state_{kScene, 0.01f};
};

TEST_F(State, DigitsChooseTheAov) {
    const std::pair<Key, const char*> rows[] = {
        {Key::two, "multiple"},  {Key::three, "single"}, {Key::four, "specular"},
        {Key::five, "exitance"}, {Key::six, "error"},    {Key::seven, "evaluations"},
        {Key::one, "beauty"}};
    for (const auto& [key, name] : rows) {
        press(key);
        EXPECT_EQ(aov_name(state_.aov()), name);
        EXPECT_EQ(state_.wish().certified, key == Key::six);  // only then there is a bound
    }
}

TEST_F(State, BracketsChangeTheExposureAlone) {
    const SceneWish before = state_.wish();
    press(Key::right_bracket);
    press(Key::right_bracket);
    EXPECT_EQ(state_.exposure(), 1);
    for (int i = 0; i < 100; ++i) press(Key::left_bracket);
    EXPECT_EQ(state_.exposure(), -16);
    EXPECT_EQ(state_.wish(), before);
}

TEST_F(State, CommaAndPeriodChangeTheTolerance) {
    press(Key::comma);
    EXPECT_FLOAT_EQ(state_.wish().tolerance, 0.005f);
    press(Key::period);
    press(Key::period);
    EXPECT_FLOAT_EQ(state_.wish().tolerance, 0.02f);
    for (int i = 0; i < 30; ++i) press(Key::comma);
    EXPECT_FLOAT_EQ(state_.wish().tolerance, 1e-4f);
    for (int i = 0; i < 30; ++i) press(Key::period);
    EXPECT_FLOAT_EQ(state_.wish().tolerance, 0.5f);
}

TEST(StateFromOtherTolerance, StepsToTheNextOfTheLadder) {
    ViewState state(kScene, 0.03f);
    state.handle(KeyEvent{Key::comma, true});
    EXPECT_FLOAT_EQ(state.wish().tolerance, 0.02f);
    ViewState other(kScene, 0.03f);
    other.handle(KeyEvent{Key::period, true});
    EXPECT_FLOAT_EQ(other.wish().tolerance, 0.05f);
}

TEST_F(State, GroupsGetBrighterOneByOne) {
    EXPECT_EQ(shown().groups[0].scale, kScene.groups[0].scale);
    press(Key::plus);
    press(Key::plus);
    press(Key::l);
    press(Key::minus);
    EXPECT_EQ(shown().groups[0].scale, Rgb(2, 4, 6));
    EXPECT_FLOAT_EQ(shown().groups[1].scale.r, std::exp2(-0.5f));
    EXPECT_EQ(state_.selected_group(), "fill -0.5 stops");
    press(Key::l);
    EXPECT_EQ(state_.selected_group(), "key +1.0 stops");
    EXPECT_EQ(shown().settings.bounces, kScene.settings.bounces);
}

TEST_F(State, PresetsGoAroundAndKeepTheIndexOfTheCache) {
    const Medium own = body(kScene, 0).medium;
    for (const Preset& preset : presets()) {
        press(Key::m);
        const Medium medium = body(shown(), 0).medium;
        EXPECT_EQ(medium.sigma_a, preset.medium.sigma_a);
        EXPECT_EQ(medium.sigma_s_prime, preset.medium.sigma_s_prime);
        EXPECT_EQ(medium.eta, own.eta);
        EXPECT_EQ(shown().settings.bounces, 0);  // indirect light was made for another medium
        EXPECT_NE(state_.selected_material().find(preset.name), std::string::npos);
    }
    press(Key::m);
    EXPECT_EQ(body(shown(), 0).medium.sigma_a, own.sigma_a);
    EXPECT_EQ(shown().settings.bounces, kScene.settings.bounces);
}

TEST_F(State, ModelsGoAround) {
    for (const auto& [name, model] : kModels) {
        press_with(Key::shift, Key::m);
        EXPECT_EQ(body(shown(), 0).model, model);
        EXPECT_EQ(body(shown(), 0).boundary_elements, model == Model::body_aware);
    }
    press_with(Key::shift, Key::m);
    EXPECT_EQ(state_.wish().materials, std::vector<MaterialWish>(3));
}

TEST_F(State, ControlChoosesAmongTranslucentMaterials) {
    EXPECT_EQ(state_.selected_material(), "wax: its own medium, model body-aware");
    press_with(Key::control, Key::m);
    EXPECT_EQ(state_.selected_material(), "stone: its own medium, model body-aware");
    press(Key::m);
    EXPECT_EQ(body(shown(), 0).medium.sigma_a, body(kScene, 0).medium.sigma_a);
    EXPECT_EQ(body(shown(), 2).medium.sigma_a, presets()[0].medium.sigma_a);
    press_with(Key::control, Key::m);
    EXPECT_EQ(state_.selected_material().substr(0, 4), "wax:");
}

TEST_F(State, ScreenshotsAreWishedForOnce) {
    EXPECT_FALSE(state_.take_screenshot_wish());
    press(Key::f12);
    EXPECT_TRUE(state_.take_screenshot_wish());
    EXPECT_FALSE(state_.take_screenshot_wish());
}

TEST_F(State, HelpAndEnd) {
    press(Key::h);
    EXPECT_TRUE(state_.help());
    press(Key::h);
    EXPECT_FALSE(state_.help());
    EXPECT_FALSE(state_.closed());
    press(Key::escape);
    EXPECT_TRUE(state_.closed());
    ViewState other(kScene, 0.01f);
    other.handle(CloseEvent{});
    EXPECT_TRUE(other.closed());
}

// A scene without bodies and lights has nothing to choose.
TEST(StateOfAnEmptyScene, HasNothingToChoose) {
    const Scene scene = scene_of(kCamera);
    ViewState state(scene, 0.01f);
    for (const Key key : {Key::l, Key::plus, Key::minus, Key::m}) state.handle(KeyEvent{key, true});
    EXPECT_EQ(state.selected_group(), "");
    EXPECT_EQ(state.selected_material(), "");
}

}  // namespace
}  // namespace tallow
