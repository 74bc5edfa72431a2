// SPDX-License-Identifier: Apache-2.0
// The section `cameras` of a scene file.
#include "common/scene/cameras_yaml.h"

#include <fmt/format.h>

namespace tallow {
namespace {

constexpr int kLargestImage = 65536;  // pixels along an edge
constexpr int kMostFrames = 65536;
constexpr Range kFieldOfView{0, 180, "an angle in (0, 180) degrees", true, true};
constexpr float kLeastDistance = 1e-12f;  // mm; as small as lengths may be

void refuse_both(const YamlMap& map, std::string_view one, std::string_view other) {
    if (map.has(one) && map.has(other))
        map.fail(other, fmt::format("cannot be given together with '{}'", one));
}

float read_fov(const YamlMap& map) { return glm::radians(map.number("fov_deg", kFieldOfView)); }

Turntable read_turntable(const YamlNode& node) {
    constexpr Range kTurn{-36000, 36000, "an angle in [-36000, 36000] degrees"};
    const YamlMap map(node, "turntable");
    map.allow_only({"frames", "axis", "degrees"});
    return {yaml_integer(map.at("frames"), "frames", 1, kMostFrames),
            map.has("axis") ? read_direction(map, "axis") : Vec3(0, 1, 0),
            glm::radians(map.number_or("degrees", kTurn, 360))};
}

/// What a keyframe does not say is as the camera says.
Keyframe read_keyframe(const YamlMap& key, const YamlMap& camera, const LengthReader& lengths) {
    const auto who_has = [&](std::string_view name) -> const YamlMap& {
        return key.has(name) ? key : camera;
    };
    key.allow_only({"frame", "position", "look_at", "fov_deg"});
    return {yaml_integer(key.at("frame"), "frame", 0, kMostFrames - 1),
            lengths.point(who_has("position"), "position"),
            lengths.point(who_has("look_at"), "look_at"), read_fov(who_has("fov_deg"))};
}

std::vector<Keyframe> read_keyframes(const YamlMap& camera, const LengthReader& lengths) {
    std::vector<Keyframe> keys;
    for (const YamlNode& node : camera.list("keyframes")) {
        const YamlMap map(node, "keyframes");
        const Keyframe key = read_keyframe(map, camera, lengths);
        if (!keys.empty() && key.frame <= keys.back().frame)
            fail_expected(map.at("frame"), "frame",
                          fmt::format("a frame after {}", keys.back().frame));
        keys.push_back(key);
    }
    if (keys.empty()) fail_expected(camera.at("keyframes"), "keyframes", "at least one keyframe");
    return keys;
}

/// Where the camera is, and how it moves.
void read_place(const YamlMap& map, const LengthReader& lengths, Camera& camera) {
    refuse_both(map, "turntable", "keyframes");
    if (map.has("keyframes")) {
        camera.up = map.has("up") ? read_direction(map, "up") : Vec3(0, 1, 0);
        camera.motion = read_keyframes(map, lengths);
        return;
    }
    const View view = read_view(map, lengths);
    camera.position = view.position, camera.look_at = view.look_at, camera.up = view.up;
    camera.fov = read_fov(map);
    if (map.has("turntable")) camera.motion = read_turntable(map.at("turntable"));
}

void read_lens(const YamlMap& map, const LengthReader& lengths, Camera& camera) {
    constexpr Range kFocus{kLeastDistance, 1e12f, "a length >= 1e-12 mm"};
    camera.lens_radius = map.number("aperture_mm", kNonNegative) / 2;
    refuse_both(map, "focus_mm", "focus_at");
    if (map.has("focus_at"))
        camera.focus_point = lengths.point(map, "focus_at");
    else if (map.has("focus_mm"))
        camera.focus = map.number("focus_mm", kFocus);
    else
        fail_at(map.where(), "", "missing key 'focus_mm' or 'focus_at'");
}

/// Refuses a frame in which nothing could be seen. The keys themselves are right; the way between
/// two keyframes may not be, and rounding may undo tiny distances.
void require_view(const YamlMap& map, const Camera& still) {
    const std::string_view motion = map.has("keyframes")   ? "keyframes"
                                    : map.has("turntable") ? "turntable"
                                                           : "look_at";
    const auto refuse = [&](std::string_view key, std::string_view why) {
        const bool moves = motion != "look_at";
        map.fail(key, moves ? fmt::format("{} in frame {}", why, still.frame) : std::string(why));
    };
    if (!(glm::distance(DVec3(still.position), DVec3(still.look_at)) >= kLeastDistance))
        refuse(motion, "expected position and look_at to be apart, got one point");
    if (is_along(still.look_at - still.position, still.up))
        refuse(motion, "expected a view that is not along 'up', got one");
    if (!(still.fov > 0 && still.fov < kPi))
        refuse("fov_deg", "expected an angle in (0, 180) degrees, got none");
    if (still.focus_point && !(still.focus >= kLeastDistance))
        refuse("focus_at", "expected a point before the camera, got one behind it");
}

Camera read_camera(const YamlEntry& entry, const LengthReader& lengths) {
    require_name(entry.key_where, entry.key);
    const YamlMap map(entry.value, entry.key);
    const bool has_lens = map.choice<bool>("type", {{"perspective", false}, {"thin-lens", true}});
    std::vector<std::string_view> keys = {"type",    "position",   "look_at",   "up",
                                          "fov_deg", "resolution", "turntable", "keyframes"};
    if (has_lens) keys.insert(keys.end(), {"aperture_mm", "focus_mm", "focus_at"});
    map.allow_only(keys);
    Camera camera{};
    camera.name = entry.key;
    read_place(map, lengths, camera);
    const auto& resolution =
        yaml_items(map.at("resolution"), "resolution", 2, "two integers [width, height]");
    camera.width = yaml_integer(resolution[0], "resolution", 1, kLargestImage);
    camera.height = yaml_integer(resolution[1], "resolution", 1, kLargestImage);
    if (has_lens) read_lens(map, lengths, camera);
    for (int frame = 0; frame < frame_count(camera); ++frame)
        require_view(map, camera_at(camera, frame));

    Camera first = camera_at(camera, 0);
    first.motion = std::move(camera.motion);
    return first;
}

}  // namespace

std::vector<Camera> read_cameras(const YamlNode& section, const LengthReader& lengths) {
    std::vector<Camera> cameras;
    for (const YamlEntry& entry : YamlMap(section, "cameras").entries())
        cameras.push_back(read_camera(entry, lengths));
    if (cameras.empty()) fail_expected(section, "cameras", "at least one camera");
    return cameras;
}

}  // namespace tallow
