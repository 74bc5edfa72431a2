// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "common/scene/yaml_map.h"

namespace tallow {

/// Reads lengths in the unit of the scene and gives them in mm.
///
/// Domain   magnitudes up to 1e12 mm, positive ones from 1e-12 mm: their cubes are normal floats.
struct LengthReader {
    float mm_per_unit = 1;
    DVec3 origin{0};  // Scene::origin, mm; subtracted from points in double

    Vec3 point(const YamlMap& map, std::string_view key) const;
    DVec3 exact_point(const YamlMap& map, std::string_view key) const;
    DVec3 exact_point_or_zero(const YamlMap& map, std::string_view key) const;
    float positive(const YamlMap& map, std::string_view key) const;
    float positive(const YamlNode& node, std::string_view key) const;
};

/// A vector that is not zero, as unit direction.
Vec3 read_direction(const YamlMap& map, std::string_view key);

/// Where something stands and what it faces; `up` is not parallel to the direction of view.
struct View {
    Vec3 position, look_at;  // mm
    Vec3 forward;            // unit
    Vec3 up;                 // unit, not perpendicular to `forward` in general
};

/// Whether a direction of view (of any length) leaves no side of `up` (unit) to be right.
bool is_along(Vec3 view, Vec3 up);

/// The keys position and look_at, and the unit direction between them; look_at must be elsewhere.
Vec3 read_forward(const YamlMap& map, const LengthReader& lengths);

/// The keys position, look_at and up (default [0, 1, 0]).
View read_view(const YamlMap& map, const LengthReader& lengths);

}  // namespace tallow
