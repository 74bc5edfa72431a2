// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/base/vec.h"

namespace tallow {

/// Keys that mean something to the viewer. Those that move stand for places on the keyboard, the
/// others for what is printed on them.
enum class Key {
    w,
    a,
    s,
    d,
    q,
    e,
    shift,
    control,
    one,
    two,
    three,
    four,
    five,
    six,
    seven,
    h,
    l,
    m,
    f12,
    escape,
    left_bracket,
    right_bracket,
    comma,
    period,
    plus,
    minus
};

enum class Button { left, right };

// What the user did. Places are pixels of the window from its top left corner.
struct KeyEvent {
    Key key;
    bool down;
};
struct ButtonEvent {
    Button button;
    bool down;
    Vec2 at;
};
struct MotionEvent {
    Vec2 at;
};
struct WheelEvent {
    float clicks;  // positive away from the user
};
struct ResizeEvent {
    int width, height;
};
struct CloseEvent {};
using InputEvent =
    std::variant<KeyEvent, ButtonEvent, MotionEvent, WheelEvent, ResizeEvent, CloseEvent>;

/// "W", "Shift", "1", "F12", "[".
std::string_view key_name(Key key);
std::optional<Key> find_key(std::string_view name);
std::vector<std::string_view> key_names();

}  // namespace tallow
