// SPDX-License-Identifier: Apache-2.0
#include "common/scene/yaml_override.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>
#include <utility>

#include "common/base/errors.h"
#include "common/base/parse_whole.h"
#include "common/scene/yaml_map.h"

namespace tallow {
namespace {

using Path = std::span<const std::string>;

std::vector<std::string> split_path(const std::string& key, const YamlWhere& flag) {
    std::vector<std::string> path;
    for (std::size_t begin = 0; begin <= key.size();) {
        const std::size_t end = std::min(key.find('.', begin), key.size());
        path.push_back(key.substr(begin, end - begin));
        if (path.back().empty()) fail_at(flag, "", "expected names separated by single dots");
        begin = end + 1;
    }
    return path;
}

/// Sections that every scene has in spirit: setting a value in them needs no line in the file.
bool may_be_absent(Path path) {
    return (path.size() == 1 && (path[0] == "groups" || path[0] == "settings")) ||
           (path.size() == 2 && path[0] == "groups");
}

std::string name_of(Path path) {
    return path.empty() ? "the scene" : printable(fmt::format("{}", fmt::join(path, ".")));
}

YamlNode& list_item(YamlNode& list, const std::string& index, Path parent, const YamlWhere& flag) {
    const auto i = parse_whole<std::size_t>(index);
    if (!i || *i >= list.items.size())
        fail_at(flag, "",
                fmt::format("{} has {} items, counted from 0, got '{}'", name_of(parent),
                            list.items.size(), printable(index)));
    return list.items[*i];
}

YamlEntry& new_entry(YamlNode& map, const std::string& key, const YamlWhere& flag) {
    YamlNode value;
    value.kind = YamlNode::Kind::map;
    value.where = flag;
    map.entries.push_back({key, flag, std::move(value)});
    return map.entries.back();
}

[[noreturn]] void fail_missing(const YamlNode& map, Path path, const YamlWhere& flag) {
    std::vector<std::string_view> keys;
    for (const YamlEntry& entry : map.entries) keys.push_back(entry.key);
    fail_at(flag, "",
            fmt::format("{} has no '{}'{}", name_of(path.first(path.size() - 1)),
                        printable(path.back()), suggestion(path.back(), keys)));
}

/// The value at the end of `path`, whose parent is `parent`. As the last step of a key it may be
/// new to its map.
YamlNode& child(YamlNode& parent, Path path, bool is_last, const YamlWhere& flag) {
    const Path parent_path = path.first(path.size() - 1);
    if (parent.kind == YamlNode::Kind::list)
        return list_item(parent, path.back(), parent_path, flag);
    if (parent.kind != YamlNode::Kind::map)
        fail_at(flag, "",
                fmt::format("expected {} to be a map or a list, got {}", name_of(parent_path),
                            describe(parent)));
    const auto entry = std::ranges::find(parent.entries, path.back(), &YamlEntry::key);
    if (entry == parent.entries.end()) {
        if (!is_last && !may_be_absent(path)) fail_missing(parent, path, flag);
        return new_entry(parent, path.back(), flag).value;
    }
    if (is_last) entry->key_where = flag;
    return entry->value;
}

}  // namespace

void apply_override(YamlNode& root, const std::string& key_and_value) {
    const std::size_t equals = key_and_value.find('=');
    if (equals == std::string::npos || equals == 0)
        throw UsageError(
            fmt::format("--set: expected KEY=VALUE, got '{}'", printable(key_and_value)));
    const std::string key = key_and_value.substr(0, equals);
    YamlNode value = parse_yaml_flag(key_and_value.substr(equals + 1), "--set " + printable(key));
    const YamlWhere flag{value.where.source};
    const std::vector<std::string> path = split_path(key, flag);
    YamlNode* node = &root;
    for (std::size_t i = 1; i <= path.size(); ++i)
        node = &child(*node, Path(path).first(i), i == path.size(), flag);
    *node = std::move(value);
}

}  // namespace tallow
