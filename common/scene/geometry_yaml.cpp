// SPDX-License-Identifier: Apache-2.0
#include "common/scene/geometry_yaml.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tallow {
namespace {

constexpr double kSmallestLength = 1 / kLargestNumber;  // mm

template <class V>
auto largest_component(V v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// In double: the squares of tiny and huge components leave the range of float.
Vec3 unit(Vec3 v) { return Vec3(glm::normalize(DVec3(v))); }

}  // namespace

DVec3 LengthReader::exact_point(const YamlMap& map, std::string_view key) const {
    const DVec3 p = map.dvec3(key) * double{mm_per_unit} - origin;
    if (largest_component(p) > kLargestNumber)
        map.fail(key, fmt::format("expected lengths of at most {:g} mm", kLargestNumber));
    return p;
}

DVec3 LengthReader::exact_point_or_zero(const YamlMap& map, std::string_view key) const {
    return map.has(key) ? exact_point(map, key) : DVec3(0);
}

Vec3 LengthReader::point(const YamlMap& map, std::string_view key) const {
    return Vec3(exact_point(map, key));
}

float LengthReader::positive(const YamlMap& map, std::string_view key) const {
    return positive(map.at(key), key);
}

float LengthReader::positive(const YamlNode& node, std::string_view key) const {
    const double length = double{yaml_number(node, key, kPositive)} * mm_per_unit;
    if (length < kSmallestLength || length > kLargestNumber)
        fail_expected(node, key,
                      fmt::format("a length in [{:g}, {:g}] mm", kSmallestLength, kLargestNumber));
    return static_cast<float>(length);
}

Vec3 read_direction(const YamlMap& map, std::string_view key) {
    const Vec3 v = map.vec3(key);
    if (largest_component(v) == 0) map.fail(key, "expected a direction, got a vector of length 0");
    return unit(v);
}

bool is_along(Vec3 view, Vec3 up) {
    // Chosen: at an angle of 0.06 degrees, float still knows which side is right to 4 digits.
    constexpr float kSmallestSine = 1e-3f;
    return glm::length(glm::cross(unit(view), up)) < kSmallestSine;
}

Vec3 read_forward(const YamlMap& map, const LengthReader& lengths) {
    const Vec3 way = lengths.point(map, "look_at") - lengths.point(map, "position");
    if (largest_component(way) == 0) map.fail("look_at", "expected another point than position");
    return unit(way);
}

View read_view(const YamlMap& map, const LengthReader& lengths) {
    View view{lengths.point(map, "position"), lengths.point(map, "look_at"),
              read_forward(map, lengths), Vec3(0, 1, 0)};
    if (map.has("up")) {
        view.up = read_direction(map, "up");
        if (is_along(view.forward, view.up))
            map.fail("up", "expected a direction that is not the direction of view");
    } else if (is_along(view.forward, view.up)) {
        view.up = Vec3(0, 0, -1);  // straight up or down: as on a map, north is up
    }
    return view;
}

}  // namespace tallow
