// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "viewer/input.h"

namespace tallow {

/// What a script lets the user do in one frame.
struct ScriptedEvent {
    int frame;
    InputEvent event;
};

/// Reads a list of events (YAML); docs/VIEWER.md has its grammar:
///
///     - {frame: 3, key: W, down: true}      # without `down`: pressed and let go
///     - {frame: 5, button: left, down: true, at: [256, 200]}
///     - {frame: 6, move: [260, 210]}
///     - {frame: 7, wheel: 2}
///     - {frame: 8, resize: [640, 480]}
///     - {frame: 9, close: true}
///
/// Frames must not go back. Throws InputError "script.yaml:2:10: key: expected X, got Y".
std::vector<ScriptedEvent> read_script(const std::filesystem::path& file);
std::vector<ScriptedEvent> parse_script(std::string_view text, const std::string& name);

}  // namespace tallow
