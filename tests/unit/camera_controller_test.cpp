// SPDX-License-Identifier: Apache-2.0
#include "viewer/camera_controller.h"

#include <gtest/gtest.h>

namespace tallow {
namespace {

const Camera kCamera{"main", {1, 2, 10}, {1, 2, 0}, {0, 1, 0}, 0.6f, 400, 300};

/// A plane at z = 0 is met everywhere.
std::optional<Vec3> on_plane(const Camera& camera, Vec2 pixel) {
    const Ray ray = camera_ray(camera, pixel.x, pixel.y);
    return ray.origin - ray.origin.z / ray.direction.z * ray.direction;
}

class Controller : public ::testing::Test {
protected:
    void press(Key key, bool down = true) { controller_.handle(KeyEvent{key, down}, on_plane); }
    void button(Button button, bool down, Vec2 at) {
        controller_.handle(ButtonEvent{button, down, at}, on_plane);
    }
    void move(Vec2 to) { controller_.handle(MotionEvent{to}, on_plane); }
    Vec3 moved() const { return controller_.camera().position - kCamera.position; }

    CameraController controller_{kCamera};
};

void expect_near(Vec3 a, Vec3 b, float error = 1e-5f) {
    EXPECT_LE(glm::distance(a, b), error)
        << a.x << ' ' << a.y << ' ' << a.z << " vs " << b.x << ' ' << b.y << ' ' << b.z;
}

/// Where a point is seen, in pixels.
Vec2 place_of(const Camera& camera, Vec3 point) {
    const Vec3 forward = glm::normalize(camera.look_at - camera.position);
    const Vec3 right = glm::normalize(glm::cross(forward, camera.up));
    const Vec3 up = glm::cross(right, forward), to = point - camera.position;
    const float pixel = 2 * std::tan(camera.fov / 2) / float(camera.height);
    return Vec2(camera.width, camera.height) / 2.0f +
           Vec2(glm::dot(to, right), -glm::dot(to, up)) / glm::dot(to, forward) / pixel;
}

TEST_F(Controller, IsTheCameraUntilSomethingIsPressed) {
    move({10, 20});
    controller_.advance(1);
    press(Key::h);
    controller_.advance(1);
    EXPECT_EQ(controller_.revision(), 0);
    EXPECT_EQ(controller_.camera().position, kCamera.position);
    EXPECT_EQ(controller_.camera().look_at, kCamera.look_at);
}

TEST_F(Controller, GoesWhereTheKeySays) {
    const float step = controller_.speed();
    EXPECT_FLOAT_EQ(step, 5);  // half of the distance in a second
    const std::pair<Key, Vec3> ways[] = {{Key::w, {0, 0, -1}}, {Key::s, {0, 0, 1}},
                                         {Key::a, {-1, 0, 0}}, {Key::d, {1, 0, 0}},
                                         {Key::q, {0, -1, 0}}, {Key::e, {0, 1, 0}}};
    for (const auto& [key, way] : ways) {
        const Vec3 before = controller_.camera().position;
        press(key);
        EXPECT_TRUE(controller_.is_moving());
        controller_.advance(0.5);
        press(key, false);
        EXPECT_FALSE(controller_.is_moving());
        controller_.advance(0.5);
        expect_near(controller_.camera().position - before, 0.5f * step * way);
    }
    expect_near(moved(), Vec3(0));
    expect_near(controller_.camera().look_at, kCamera.look_at);
}

TEST_F(Controller, ShiftAndWheelMakeItFaster) {
    press(Key::w);
    press(Key::shift);
    controller_.advance(0.1);
    expect_near(moved(), {0, 0, -2});
    press(Key::shift, false);
    controller_.handle(WheelEvent{2}, on_plane);
    EXPECT_FLOAT_EQ(controller_.speed(), 5 * 1.25f * 1.25f);
    controller_.handle(WheelEvent{-2}, on_plane);
    EXPECT_FLOAT_EQ(controller_.speed(), 5);
    controller_.handle(WheelEvent{-100}, on_plane);
    for (int i = 0; i < 20; ++i) controller_.handle(WheelEvent{-100}, on_plane);
    EXPECT_GT(controller_.speed(), 0);
}

TEST_F(Controller, OppositeKeysCancel) {
    press(Key::w);
    press(Key::s);
    controller_.advance(1);
    EXPECT_EQ(controller_.revision(), 0);
}

TEST_F(Controller, RightButtonTurnsOnTheSpot) {
    button(Button::right, true, {100, 100});
    move({140, 100});  // to the right by 0.2 rad
    expect_near(moved(), Vec3(0));
    expect_near(controller_.camera().look_at - controller_.camera().position,
                10.0f * Vec3(std::sin(0.2f), 0, -std::cos(0.2f)));
    button(Button::right, false, {140, 100});
    const int revision = controller_.revision();
    move({300, 200});
    EXPECT_EQ(controller_.revision(), revision);
}

TEST_F(Controller, LeftButtonOrbitsAroundThePointUnderIt) {
    const Vec2 at(260, 90);
    const Vec3 pivot = *on_plane(kCamera, at);
    button(Button::left, true, at);
    for (const Vec2 to : {Vec2(300, 120), Vec2(250, 40), Vec2(100, 200)}) {
        move(to);
        const Camera& camera = controller_.camera();
        EXPECT_NEAR(glm::distance(camera.position, pivot), glm::distance(kCamera.position, pivot),
                    1e-4);
        EXPECT_NEAR(glm::distance(camera.position, camera.look_at), 10, 1e-4);
        const Vec2 seen = place_of(camera, pivot);
        EXPECT_NEAR(seen.x, at.x, 0.01);
        EXPECT_NEAR(seen.y, at.y, 0.01);
    }
}

// Dragged down, the camera comes over the top, and stops before it looks along up.
TEST_F(Controller, StopsBeforeThePole) {
    button(Button::left, true, {200, 150});
    move({200, 5000});
    const Camera& camera = controller_.camera();
    EXPECT_GT(camera.position.y, 11);
    const float elevation = std::asin(glm::normalize(camera.look_at - camera.position).y);
    EXPECT_NEAR(elevation, -(kPi / 2 - 0.05f), 1e-3);
    move({210, 5100});
    EXPECT_TRUE(is_finite(controller_.camera().position));
}

TEST_F(Controller, WithoutAPointItOrbitsAroundWhatIsLookedAt) {
    const auto nothing = [](const Camera&, Vec2) { return std::optional<Vec3>(); };
    controller_.handle(ButtonEvent{Button::left, true, {0, 0}}, nothing);
    controller_.handle(MotionEvent{{50, 10}}, nothing);
    expect_near(controller_.camera().look_at, kCamera.look_at);
    EXPECT_NE(controller_.camera().position, kCamera.position);
}

TEST_F(Controller, TakesTheSizeOfTheWindow) {
    controller_.handle(ResizeEvent{400, 300}, on_plane);
    EXPECT_EQ(controller_.revision(), 0);
    controller_.handle(ResizeEvent{640, 200}, on_plane);
    EXPECT_EQ(controller_.camera().width, 640);
    EXPECT_EQ(controller_.camera().height, 200);
    EXPECT_EQ(controller_.revision(), 1);
}

// Many small steps do not shrink or stretch the view.
TEST_F(Controller, KeepsItsDistances) {
    button(Button::left, true, {260, 90});
    press(Key::w);
    for (int i = 0; i < 20000; ++i) {
        move({float(i % 400), float((7 * i) % 300)});
        controller_.advance(1e-5);
    }
    const Camera& camera = controller_.camera();
    EXPECT_NEAR(glm::distance(camera.position, camera.look_at), 10, 0.01);
}

}  // namespace
}  // namespace tallow
