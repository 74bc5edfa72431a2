// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "tests/support/error_text.h"
#include "viewer/script.h"

namespace tallow {
namespace {

TEST(Script, HasAllEvents) {
    const auto events = parse_script(R"(
- {frame: 0, key: W, down: true}
- {frame: 3, key: W, down: false}
- {frame: 3, key: "["}
- {frame: 4, button: right, down: true, at: [10, 20.5]}
- {frame: 5, move: [-1, 2]}
- {frame: 6, wheel: -2}
- {frame: 7, resize: [64, 48]}
- {frame: 8, close: true}
)",
                                     "s.yaml");
    ASSERT_EQ(events.size(), 9u);
    EXPECT_EQ(events[1].frame, 3);
    EXPECT_FALSE(std::get<KeyEvent>(events[1].event).down);
    EXPECT_EQ(std::get<KeyEvent>(events[2].event).key, Key::left_bracket);
    EXPECT_TRUE(std::get<KeyEvent>(events[2].event).down);
    EXPECT_FALSE(std::get<KeyEvent>(events[3].event).down);
    EXPECT_EQ(std::get<ButtonEvent>(events[4].event).at, Vec2(10, 20.5f));
    EXPECT_EQ(std::get<MotionEvent>(events[5].event).at, Vec2(-1, 2));
    EXPECT_EQ(std::get<WheelEvent>(events[6].event).clicks, -2);
    EXPECT_EQ(std::get<ResizeEvent>(events[7].event).height, 48);
    EXPECT_TRUE(std::holds_alternative<CloseEvent>(events[8].event));
}

TEST(Script, KeysHaveNames) {
    for (const std::string_view name : key_names()) EXPECT_EQ(key_name(*find_key(name)), name);
    EXPECT_FALSE(find_key("w"));
    EXPECT_EQ(key_names().size(), std::size_t(Key::minus) + 1);
}

TEST(Script, SaysWhatIsWrongAndWhere) {
    const std::pair<const char*, const char*> rows[] = {
        {"{a: 1}", "s.yaml:1:1: script: expected a list of events, got a map"},
        {"- {key: W}", "s.yaml:1:3: missing key 'frame'"},
        {"- {frame: -1, key: W}",
         "s.yaml:1:11: frame: expected an integer in [0, 1000000], got '-1'"},
        {"- {frame: 2, key: W}\n- {frame: 1, key: W}",
         "s.yaml:2:11: frame: expected a frame that is not before 2, got '1'"},
        {"- {frame: 2, key: W, down: 1}",
         "s.yaml:1:28: down: expected one of true, false, got '1'"},
        {"- {frame: 2, button: middle, down: true, at: [0, 0]}",
         "s.yaml:1:22: button: expected one of left, right, got 'middle'"},
        {"- {frame: 2, button: left, down: true}", "s.yaml:1:3: missing key 'at'"},
        {"- {frame: 2, resize: [0, 3]}",
         "s.yaml:1:23: resize: expected an integer in [1, 16384], got '0'"},
        {"- {frame: 2, move: [.nan, 3]}",
         "s.yaml:1:21: move: expected a place in pixels, got '.nan'"},
        {"- {frame: 2, wheel: fast}",
         "s.yaml:1:21: wheel: expected a number of clicks in [-100, 100], got 'fast'"},
    };
    for (const auto& [text, message] : rows)
        EXPECT_EQ(error_text<InputError>([&] { parse_script(text, "s.yaml"); }), message) << text;
    const std::string unknown =
        error_text<InputError>([&] { parse_script("- {frame: 0, key: X}", "s.yaml"); });
    EXPECT_TRUE(unknown.starts_with("s.yaml:1:19: key: expected one of W A S D")) << unknown;
}

}  // namespace
}  // namespace tallow
