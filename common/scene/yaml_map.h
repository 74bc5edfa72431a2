// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/rgb.h"
#include "common/base/vec.h"
#include "common/scene/yaml_tree.h"

namespace tallow {

/// Numbers that a key accepts, and how users are told. Judged after rounding to float, so that
/// 1e-60 is not > 0.
struct Range {
    float low, high;
    std::string_view text;
    bool open_low = false, open_high = false;  // whether the bound itself is excluded

    bool contains(float x) const {
        return (open_low ? x > low : x >= low) && (open_high ? x < high : x <= high);
    }
};

/// Largest magnitude of any number in a scene but those of light. Chosen: its cube is still a
/// finite float, so that nothing behind the border need guard products of lengths or coefficients
/// against overflow.
inline constexpr double kLargestNumber = 1e12;

inline constexpr Range kAnyNumber{-1e12f, 1e12f, "a number"};
inline constexpr Range kPositive{0, 1e12f, "a number > 0", true};
inline constexpr Range kNonNegative{0, 1e12f, "a number >= 0"};
/// Intensities of light: sums over a scene's surfaces stay finite floats.
inline constexpr Range kRadiometric{0, 1e30f, "a number >= 0"};
inline constexpr Range kZeroToOne{0, 1, "a number in [0, 1]"};

/// Reads a YAML map key by key. Every function throws (see fail_at) when the value is not what the
/// key expects; a missing key is reported at the map itself. `_or` returns `fallback` where the
/// key is absent.
class YamlMap {
public:
    /// `name` is what messages call the value when it is not a map.
    YamlMap(const YamlNode& node, std::string_view name);

    /// Refuses keys that are not in `keys`, suggesting the nearest. To be called before reading.
    void allow_only(std::span<const std::string_view> keys) const;
    void allow_only(std::initializer_list<std::string_view> keys) const {
        allow_only(std::span(keys.begin(), keys.size()));
    }

    const std::vector<YamlEntry>& entries() const { return node_.entries; }
    const YamlWhere& where() const { return node_.where; }
    bool has(std::string_view key) const { return find(key) != nullptr; }
    const YamlEntry* find(std::string_view key) const;
    const YamlNode& at(std::string_view key) const;

    float number(std::string_view key, const Range& range) const;
    float number_or(std::string_view key, const Range& range, float fallback) const;
    int integer_or(std::string_view key, int low, int high, int fallback) const;
    std::string text(std::string_view key) const;
    Vec3 vec3(std::string_view key) const;
    DVec3 dvec3(std::string_view key) const;
    /// [r, g, b], or one number for a grey.
    Rgb rgb(std::string_view key, const Range& range) const;
    Rgb rgb_or(std::string_view key, const Range& range, Rgb fallback) const;
    /// Items of a list.
    const std::vector<YamlNode>& list(std::string_view key) const;

    /// The value that stands beside the key's text in `choices`.
    template <class T>
    T choice(std::string_view key,
             std::initializer_list<std::pair<std::string_view, T>> choices) const {
        std::vector<std::string_view> names;
        for (const auto& option : choices) names.push_back(option.first);
        return (choices.begin() + static_cast<std::ptrdiff_t>(choose(key, names)))->second;
    }
    template <class T>
    T choice_or(std::string_view key, std::initializer_list<std::pair<std::string_view, T>> choices,
                T fallback) const {
        return has(key) ? choice(key, choices) : fallback;
    }

    /// Reports that the value of `key` is wrong, or, where the key is absent, that the map is.
    [[noreturn]] void fail(std::string_view key, std::string_view message) const;

private:
    std::size_t choose(std::string_view key, std::span<const std::string_view> names) const;

    const YamlNode& node_;
};

/// The same for values that stand alone; `key` is what messages call them.
double yaml_double(const YamlNode& node, std::string_view key, const Range& range);
float yaml_number(const YamlNode& node, std::string_view key, const Range& range);
int yaml_integer(const YamlNode& node, std::string_view key, int low, int high);
DVec3 yaml_dvec3(const YamlNode& node, std::string_view key);
/// The items of a list of `count`; `expected` tells users what they are.
const std::vector<YamlNode>& yaml_items(const YamlNode& node, std::string_view key,
                                        std::size_t count, std::string_view expected);
std::string yaml_text(const YamlNode& node, std::string_view key);

/// Refuses a name (of a camera, material, light group) that could not be told apart in a list of
/// names, a path of --set, or a cache's fingerprint. `where` is the name's place.
void require_name(const YamlWhere& where, std::string_view name);

/// Reports "key: expected X, got <the value>".
[[noreturn]] void fail_expected(const YamlNode& node, std::string_view key,
                                std::string_view expected);

/// ", did you mean 'sigma_a'?" for the name nearest to `text`, or nothing if none is near.
std::string suggestion(std::string_view text, std::span<const std::string_view> names);

/// "one of flat, smooth".
std::string one_of(std::span<const std::string_view> names);

}  // namespace tallow
