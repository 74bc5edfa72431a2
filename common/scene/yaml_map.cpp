// SPDX-License-Identifier: Apache-2.0
#include "common/scene/yaml_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "common/base/parse_whole.h"

namespace tallow {
namespace {

/// A finite number written as YAML writes numbers; nothing for ".nan", "1.5mm" or what overflows.
std::optional<double> parse_number(const YamlNode& node) {
    if (node.kind != YamlNode::Kind::scalar || node.quoted) return std::nullopt;
    std::string_view text = node.text;
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
    const auto value = parse_whole<double>(text);
    return value && std::isfinite(*value) ? value : std::nullopt;
}

/// Insertions, deletions and substitutions that turn `a` into `b`; Wagner, Fischer 1974.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);  // distances of a's prefix to each prefix of b
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t substituted = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, substituted});
        }
    }
    return row.back();
}

}  // namespace

std::string one_of(std::span<const std::string_view> names) {
    return fmt::format("one of {}", fmt::join(names, ", "));
}

std::string suggestion(std::string_view text, std::span<const std::string_view> names) {
    constexpr std::size_t kMaxDistance = 2;  // chosen: two slips; at three "size" becomes "file"
    constexpr std::size_t kMaxLength = 64;   // keeps hostile keys from costing time
    if (text.size() > kMaxLength) return "";
    std::string_view nearest;
    std::size_t least = kMaxDistance + 1;
    for (const std::string_view name : names) {
        const std::size_t distance = edit_distance(text, name);
        if (distance >= least || distance >= name.size()) continue;
        least = distance;
        nearest = name;
    }
    return nearest.empty() ? "" : fmt::format(", did you mean '{}'?", nearest);
}

void fail_expected(const YamlNode& node, std::string_view key, std::string_view expected) {
    fail_at(node.where, key, fmt::format("expected {}, got {}", expected, describe(node)));
}

double yaml_double(const YamlNode& node, std::string_view key, const Range& range) {
    const auto value = parse_number(node);
    if (!value) fail_expected(node, key, range.text);
    const double largest = std::max(kLargestNumber, double{range.high});
    if (std::abs(*value) > largest)
        fail_expected(node, key, fmt::format("a magnitude of at most {:g}", largest));
    if (!range.contains(static_cast<float>(*value))) fail_expected(node, key, range.text);
    return *value;
}

float yaml_number(const YamlNode& node, std::string_view key, const Range& range) {
    return static_cast<float>(yaml_double(node, key, range));
}

int yaml_integer(const YamlNode& node, std::string_view key, int low, int high) {
    const bool plain = node.kind == YamlNode::Kind::scalar && !node.quoted;
    const auto value = plain ? parse_whole<int>(node.text) : std::nullopt;
    if (!value || *value < low || *value > high)
        fail_expected(node, key, fmt::format("an integer in [{}, {}]", low, high));
    return *value;
}

const std::vector<YamlNode>& yaml_items(const YamlNode& node, std::string_view key,
                                        std::size_t count, std::string_view expected) {
    if (node.kind != YamlNode::Kind::list || node.items.size() != count)
        fail_expected(node, key, expected);
    return node.items;
}

DVec3 yaml_dvec3(const YamlNode& node, std::string_view key) {
    const auto& items = yaml_items(node, key, 3, "three numbers [x, y, z]");
    return {yaml_double(items[0], key, kAnyNumber), yaml_double(items[1], key, kAnyNumber),
            yaml_double(items[2], key, kAnyNumber)};
}

std::string yaml_text(const YamlNode& node, std::string_view key) {
    if (node.kind != YamlNode::Kind::scalar || node.text.empty())
        fail_expected(node, key, "a text");
    return node.text;
}

void require_name(const YamlWhere& where, std::string_view name) {
    const bool good = !name.empty() && std::ranges::none_of(name, [](unsigned char c) {
        return c < 0x20 || c == 0x7f || c == '.' || c == ',' || c == '=';
    });
    if (!good)
        fail_at(where, "",
                fmt::format("expected a name without '.', ',', '=', got '{}'", printable(name)));
}

YamlMap::YamlMap(const YamlNode& node, std::string_view name) : node_(node) {
    if (node.kind != YamlNode::Kind::map) fail_expected(node, name, "a map");
}

void YamlMap::allow_only(std::span<const std::string_view> keys) const {
    for (const YamlEntry& entry : node_.entries) {
        if (std::ranges::find(keys, entry.key) != keys.end()) continue;
        const std::string near = suggestion(entry.key, keys);
        fail_at(entry.key_where, printable(entry.key),
                "unknown key" + (near.empty() ? ", expected " + one_of(keys) : near));
    }
}

const YamlEntry* YamlMap::find(std::string_view key) const {
    const auto found = std::ranges::find(node_.entries, key, &YamlEntry::key);
    return found == node_.entries.end() ? nullptr : &*found;
}

const YamlNode& YamlMap::at(std::string_view key) const {
    const YamlEntry* entry = find(key);
    if (!entry) fail_at(node_.where, "", fmt::format("missing key '{}'", key));
    return entry->value;
}

void YamlMap::fail(std::string_view key, std::string_view message) const {
    const YamlEntry* entry = find(key);
    fail_at(entry ? entry->value.where : node_.where, key, message);
}

float YamlMap::number(std::string_view key, const Range& range) const {
    return yaml_number(at(key), key, range);
}

float YamlMap::number_or(std::string_view key, const Range& range, float fallback) const {
    return has(key) ? number(key, range) : fallback;
}

int YamlMap::integer_or(std::string_view key, int low, int high, int fallback) const {
    return has(key) ? yaml_integer(at(key), key, low, high) : fallback;
}

std::string YamlMap::text(std::string_view key) const { return yaml_text(at(key), key); }

Vec3 YamlMap::vec3(std::string_view key) const { return Vec3(dvec3(key)); }
DVec3 YamlMap::dvec3(std::string_view key) const { return yaml_dvec3(at(key), key); }

Rgb YamlMap::rgb(std::string_view key, const Range& range) const {
    const YamlNode& node = at(key);
    if (node.kind == YamlNode::Kind::scalar) return Rgb(yaml_number(node, key, range));
    const auto& items = yaml_items(node, key, 3, "a number or three [r, g, b]");
    return {yaml_number(items[0], key, range), yaml_number(items[1], key, range),
            yaml_number(items[2], key, range)};
}

Rgb YamlMap::rgb_or(std::string_view key, const Range& range, Rgb fallback) const {
    return has(key) ? rgb(key, range) : fallback;
}

const std::vector<YamlNode>& YamlMap::list(std::string_view key) const {
    const YamlNode& node = at(key);
    if (node.kind != YamlNode::Kind::list) fail_expected(node, key, "a list");
    return node.items;
}

std::size_t YamlMap::choose(std::string_view key, std::span<const std::string_view> names) const {
    const YamlNode& node = at(key);
    const auto found =
        node.kind == YamlNode::Kind::scalar ? std::ranges::find(names, node.text) : names.end();
    if (found == names.end()) fail_expected(node, key, one_of(names));
    return static_cast<std::size_t>(found - names.begin());
}

}  // namespace tallow
