// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace tallow {

/// Where something was written: a place in a file, or a flag such as "--set materials.wax.eta".
struct YamlWhere {
    std::shared_ptr<const std::string> source;  // file name, or the flag
    int line = 0, column = 0;                   // from 1; line 0 for a flag

    bool is_flag() const { return line == 0; }
    std::string text() const;  ///< "scene.yaml:12:5", or the flag
};

/// Throws what a wrong value at `where` deserves: InputError "scene.yaml:12:5: key: message" for a
/// file; UsageError "--set materials.wax.eta: message" for a flag, which names the key already.
[[noreturn]] void fail_at(const YamlWhere& where, std::string_view key, std::string_view message);

struct YamlEntry;

/// A value of a YAML document with its place in the source. Aliases are expanded; null stands for
/// `key:` with nothing behind it as well as for `~`.
struct YamlNode {
    enum class Kind { null, scalar, list, map };

    Kind kind = Kind::null;
    bool quoted = false;             // a scalar in quotes is a text, never a number
    std::string text;                // of a scalar
    std::vector<YamlNode> items;     // of a list
    std::vector<YamlEntry> entries;  // of a map, in file order, keys distinct
    YamlWhere where;
};

struct YamlEntry {
    std::string key;
    YamlWhere key_where;
    YamlNode value;
};

/// What an error message calls a value: "'1.5mm'", "a list of 2", "a map", "nothing".
std::string describe(const YamlNode& node);

/// `text` on one line and short enough for an error message.
std::string printable(std::string_view text);

/// Parses one YAML document (JSON is one). Everything that a hostile file could use to exhaust the
/// machine is limited: bytes, values after expansion of aliases, depth of nesting.
///
/// Throws   InputError "name:line:column: ..." for wrong syntax, repeated keys, keys that are not
///          plain scalars, tags, several documents, an empty document.
YamlNode parse_yaml(std::string_view text, const std::string& name);

/// The same for a value on the command line: places are `flag`, errors are UsageError.
YamlNode parse_yaml_flag(std::string_view text, const std::string& flag);

/// Reads and parses a file. Throws InputError "scene.yaml: cannot be read: <reason>" as well.
YamlNode read_yaml(const std::filesystem::path& file);

}  // namespace tallow
