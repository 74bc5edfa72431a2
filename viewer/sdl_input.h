// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SDL.h>

#include <vector>

#include "viewer/input.h"

namespace tallow {

/// What an event of SDL means to the viewer: nothing, or one or more events. Keys that move are
/// known by their place on the keyboard, letters by what is printed on them, and signs by the text
/// that they type, wherever a layout puts them.
std::vector<InputEvent> translate(const SDL_Event& event);

}  // namespace tallow
