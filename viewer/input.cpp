// SPDX-License-Identifier: Apache-2.0
#include "viewer/input.h"

#include <algorithm>
#include <array>
#include <utility>

namespace tallow {
namespace {

constexpr std::array<std::pair<Key, std::string_view>, 26> kNames = {{
    {Key::w, "W"},
    {Key::a, "A"},
    {Key::s, "S"},
    {Key::d, "D"},
    {Key::q, "Q"},
    {Key::e, "E"},
    {Key::shift, "Shift"},
    {Key::control, "Control"},
    {Key::one, "1"},
    {Key::two, "2"},
    {Key::three, "3"},
    {Key::four, "4"},
    {Key::five, "5"},
    {Key::six, "6"},
    {Key::seven, "7"},
    {Key::h, "H"},
    {Key::l, "L"},
    {Key::m, "M"},
    {Key::f12, "F12"},
    {Key::escape, "Escape"},
    {Key::left_bracket, "["},
    {Key::right_bracket, "]"},
    {Key::comma, ","},
    {Key::period, "."},
    {Key::plus, "+"},
    {Key::minus, "-"},
}};

}  // namespace

std::string_view key_name(Key key) {
    return std::ranges::find(kNames, key, &decltype(kNames)::value_type::first)->second;
}

std::optional<Key> find_key(std::string_view name) {
    const auto found = std::ranges::find(kNames, name, &decltype(kNames)::value_type::second);
    return found == kNames.end() ? std::nullopt : std::optional(found->first);
}

std::vector<std::string_view> key_names() {
    std::vector<std::string_view> names;
    for (const auto& [key, name] : kNames) names.push_back(name);
    return names;
}

}  // namespace tallow
