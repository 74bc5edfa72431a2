// SPDX-License-Identifier: Apache-2.0
#include "common/scene/transform_yaml.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace tallow {
namespace {

constexpr Range kScale{-1e6f, 1e6f, "a factor of magnitude in [1e-06, 1e+06]"};

float read_scale_factor(const YamlNode& node) {
    const float factor = yaml_number(node, "scale", kScale);
    // The lower bound keeps determinants of a few steps far from underflow.
    if (std::abs(factor) < 1e-6f) fail_expected(node, "scale", kScale.text);
    return factor;
}

Placement read_scale(const YamlMap& map, const LengthReader&) {
    const YamlNode& node = map.at("scale");
    constexpr const char* kExpected = "a number > 0 or three [x, y, z]";
    Vec3 factors;
    if (node.kind == YamlNode::Kind::scalar) {
        factors = Vec3(read_scale_factor(node));
        if (factors.x < 0) fail_expected(node, "scale", kExpected);
    } else {
        const auto& items = yaml_items(node, "scale", 3, kExpected);
        factors = {read_scale_factor(items[0]), read_scale_factor(items[1]),
                   read_scale_factor(items[2])};
    }
    return {glm::dmat3(factors.x, 0, 0, 0, factors.y, 0, 0, 0, factors.z), DVec3(0)};
}

Placement read_rotation(const YamlMap& map, const LengthReader&) {
    const auto& items =
        yaml_items(map.at("rotate_deg"), "rotate_deg", 4, "four numbers [x, y, z, degrees]");
    glm::dvec4 v;
    for (int i = 0; i < 4; ++i)
        v[i] = yaml_number(items[static_cast<std::size_t>(i)], "rotate_deg", kAnyNumber);
    if (DVec3(v) == DVec3(0)) map.fail("rotate_deg", "expected an axis, got a vector of length 0");
    const glm::dmat4 rotation =
        glm::rotate(glm::dmat4(1), glm::radians(v.w), glm::normalize(DVec3(v)));
    return {glm::dmat3(rotation), DVec3(0)};
}

Placement read_translation(const YamlMap& map, const LengthReader& lengths) {
    return {glm::dmat3(1), lengths.exact_point(map, "translate")};
}

/// One step of a transform: a map of a single key.
Placement read_step(const YamlNode& node, const LengthReader& lengths) {
    const YamlMap map(node, "transform");
    map.allow_only({"scale", "rotate_deg", "translate"});
    if (map.entries().size() != 1)
        fail_at(node.where, "transform",
                fmt::format("expected one key in each step, got {}", map.entries().size()));
    if (map.has("scale")) return read_scale(map, lengths);
    if (map.has("rotate_deg")) return read_rotation(map, lengths);
    return read_translation(map, lengths);
}

}  // namespace

Placement compose(const Placement& outer, const Placement& inner) {
    return {outer.linear * inner.linear, outer.point(inner.translation)};
}

Placement read_transform(const YamlMap& map, const LengthReader& lengths) {
    Placement transform;
    if (!map.has("transform")) return transform;
    for (const YamlNode& step : map.list("transform"))
        transform = compose(read_step(step, lengths), transform);
    const double det = std::abs(glm::determinant(transform.linear));
    // Not a comparison that NaN passes: the product of many steps may overflow.
    if (!(det >= 1e-18 && det <= 1e18 && is_finite(Vec3(transform.translation))))
        map.fail("transform", "expected a change of volume in [1e-18, 1e+18] altogether");
    return transform;
}

}  // namespace tallow
