// SPDX-License-Identifier: Apache-2.0
// YAML -> events.
#include "viewer/script.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/scene/yaml_map.h"

namespace tallow {
namespace {

constexpr int kMostFrames = 1'000'000;
constexpr int kLargestWindow = 16384;  // pixels along an edge
constexpr Range kPlace{-16384, 16384, "a place in pixels"};
constexpr Range kClicks{-100, 100, "a number of clicks in [-100, 100]"};

Vec2 read_place(const YamlMap& map, std::string_view key) {
    const auto& items = yaml_items(map.at(key), key, 2, "two numbers [x, y]");
    return {yaml_number(items[0], key, kPlace), yaml_number(items[1], key, kPlace)};
}

bool read_flag(const YamlMap& map, std::string_view key) {
    return map.choice<bool>(key, {{"true", true}, {"false", false}});
}

void read_key(const YamlMap& map, int frame, std::vector<ScriptedEvent>& events) {
    map.allow_only({"frame", "key", "down"});
    const std::string name = yaml_text(map.at("key"), "key");
    const std::optional<Key> key = find_key(name);
    if (!key)
        fail_expected(map.at("key"), "key", fmt::format("one of {}", fmt::join(key_names(), " ")));
    if (!map.has("down") || read_flag(map, "down")) events.push_back({frame, KeyEvent{*key, true}});
    if (!map.has("down") || !read_flag(map, "down"))
        events.push_back({frame, KeyEvent{*key, false}});
}

InputEvent read_button(const YamlMap& map) {
    map.allow_only({"frame", "button", "down", "at"});
    return ButtonEvent{
        map.choice<Button>("button", {{"left", Button::left}, {"right", Button::right}}),
        read_flag(map, "down"), read_place(map, "at")};
}

InputEvent read_resize(const YamlMap& map) {
    map.allow_only({"frame", "resize"});
    const auto& items = yaml_items(map.at("resize"), "resize", 2, "two integers [width, height]");
    return ResizeEvent{yaml_integer(items[0], "resize", 1, kLargestWindow),
                       yaml_integer(items[1], "resize", 1, kLargestWindow)};
}

void read_event(const YamlMap& map, int frame, std::vector<ScriptedEvent>& events) {
    if (map.has("key")) {
        read_key(map, frame, events);
    } else if (map.has("button")) {
        events.push_back({frame, read_button(map)});
    } else if (map.has("resize")) {
        events.push_back({frame, read_resize(map)});
    } else if (map.has("move")) {
        map.allow_only({"frame", "move"});
        events.push_back({frame, MotionEvent{read_place(map, "move")}});
    } else if (map.has("wheel")) {
        map.allow_only({"frame", "wheel"});
        events.push_back({frame, WheelEvent{map.number("wheel", kClicks)}});
    } else {
        map.allow_only({"frame", "close"});
        if (read_flag(map, "close")) events.push_back({frame, CloseEvent{}});
    }
}

std::vector<ScriptedEvent> read_events(const YamlNode& root) {
    if (root.kind != YamlNode::Kind::list) fail_expected(root, "script", "a list of events");
    std::vector<ScriptedEvent> events;
    for (const YamlNode& node : root.items) {
        const YamlMap map(node, "event");
        const int frame = yaml_integer(map.at("frame"), "frame", 0, kMostFrames);
        if (!events.empty() && frame < events.back().frame)
            fail_expected(map.at("frame"), "frame",
                          fmt::format("a frame that is not before {}", events.back().frame));
        read_event(map, frame, events);
    }
    return events;
}

}  // namespace

std::vector<ScriptedEvent> read_script(const std::filesystem::path& file) {
    return read_events(read_yaml(file));
}

std::vector<ScriptedEvent> parse_script(std::string_view text, const std::string& name) {
    return read_events(parse_yaml(text, name));
}

}  // namespace tallow
