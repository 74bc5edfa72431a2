// SPDX-License-Identifier: Apache-2.0
#include "viewer/sdl_input.h"

namespace tallow {
namespace {

std::optional<Key> key_of(const SDL_Keysym& key) {
    switch (key.scancode) {
        case SDL_SCANCODE_W:
            return Key::w;
        case SDL_SCANCODE_A:
            return Key::a;
        case SDL_SCANCODE_S:
            return Key::s;
        case SDL_SCANCODE_D:
            return Key::d;
        case SDL_SCANCODE_Q:
            return Key::q;
        case SDL_SCANCODE_E:
            return Key::e;
        case SDL_SCANCODE_F12:
            return Key::f12;
        case SDL_SCANCODE_ESCAPE:
            return Key::escape;
        case SDL_SCANCODE_LSHIFT:
        case SDL_SCANCODE_RSHIFT:
            return Key::shift;
        case SDL_SCANCODE_LCTRL:
        case SDL_SCANCODE_RCTRL:
            return Key::control;
        default:
            break;
    }
    // The row of digits and the keypad, whatever the row types without Shift.
    if (key.scancode >= SDL_SCANCODE_1 && key.scancode <= SDL_SCANCODE_7)
        return Key(int(Key::one) + int(key.scancode) - int(SDL_SCANCODE_1));
    if (key.scancode >= SDL_SCANCODE_KP_1 && key.scancode <= SDL_SCANCODE_KP_7)
        return Key(int(Key::one) + int(key.scancode) - int(SDL_SCANCODE_KP_1));
    switch (key.sym) {
        case SDLK_h:
            return Key::h;
        case SDLK_l:
            return Key::l;
        case SDLK_m:
            return Key::m;
        default:
            return std::nullopt;
    }
}

std::vector<InputEvent> type(const char* text) {
    std::vector<InputEvent> events;
    for (; *text != '\0'; ++text) {
        // Shift is not asked for: plus and equals share a key on many layouts.
        const char sign = *text == '=' ? '+' : *text;
        if (std::string_view("[],.+-").find(sign) == std::string_view::npos) continue;
        const Key key = *find_key(std::string_view(&sign, 1));
        events.push_back(KeyEvent{key, true});
        events.push_back(KeyEvent{key, false});
    }
    return events;
}

std::optional<Button> button_of(const SDL_MouseButtonEvent& event) {
    if (event.button == SDL_BUTTON_LEFT) return Button::left;
    if (event.button == SDL_BUTTON_RIGHT) return Button::right;
    return std::nullopt;
}

Vec2 place(int x, int y) { return {float(x), float(y)}; }

}  // namespace

std::vector<InputEvent> translate(const SDL_Event& event) {
    switch (event.type) {
        case SDL_QUIT:
            return {CloseEvent{}};
        case SDL_KEYDOWN:
        case SDL_KEYUP:
            if (const auto key = key_of(event.key.keysym); key && event.key.repeat == 0)
                return {KeyEvent{*key, event.type == SDL_KEYDOWN}};
            return {};
        case SDL_TEXTINPUT:
            return type(event.text.text);
        case SDL_MOUSEBUTTONDOWN:
        case SDL_MOUSEBUTTONUP:
            if (const auto button = button_of(event.button))
                return {ButtonEvent{*button, event.type == SDL_MOUSEBUTTONDOWN,
                                    place(event.button.x, event.button.y)}};
            return {};
        case SDL_MOUSEMOTION:
            return {MotionEvent{place(event.motion.x, event.motion.y)}};
        case SDL_MOUSEWHEEL:
            return {WheelEvent{event.wheel.preciseY}};
        case SDL_WINDOWEVENT:
            if (event.window.event == SDL_WINDOWEVENT_SIZE_CHANGED)
                return {ResizeEvent{event.window.data1, event.window.data2}};
            return {};
        default:
            return {};
    }
}

}  // namespace tallow
