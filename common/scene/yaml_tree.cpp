// SPDX-License-Identifier: Apache-2.0
// YAML text -> tree of values with positions, over the event interface of yaml-cpp. Its own tree
// (YAML::Node) keeps the first of two equal keys silently and places an alias at its anchor; the
// events tell both, and let us stop before a document grows too deep or too large.
#include "common/scene/yaml_tree.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "common/base/errors.h"

namespace tallow {
namespace {

// Limits, all chosen: far above what a scene needs (a scene nests 5 deep; 100 000 spheres are
// 800 000 values), far below what exhausts the stack or the memory.
constexpr std::size_t kMaxBytes = std::size_t{64} << 20;
constexpr std::size_t kMaxValues = 2'000'000;
constexpr int kMaxDepth = 32;

class TreeBuilder : public YAML::EventHandler {
public:
    TreeBuilder(std::shared_ptr<const std::string> source, bool is_flag)
        : source_(std::move(source)), is_flag_(is_flag) {}

    YamlNode take() { return std::move(root_); }
    YamlWhere where(const YAML::Mark& mark) const {
        if (is_flag_) return {source_};
        return {source_, std::max(mark.line, 0) + 1, std::max(mark.column, 0) + 1};
    }

    void OnDocumentStart(const YAML::Mark& mark) override {
        if (std::exchange(started_, true))
            fail_at(where(mark), "", "expected one document, got a second");
    }
    void OnDocumentEnd() override {}

    void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
        YamlNode node;
        node.where = where(mark);
        // What is empty has no place of its own: yaml-cpp marks the token after it.
        if (!open_.empty() && open_.back().has_key) node.where = open_.back().key_where;
        add(std::move(node), anchor);
    }

    void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
        const auto found = anchors_.find(anchor);
        if (found == anchors_.end())
            fail_at(where(mark), "", "an alias may not refer to the list or map that it is in");
        const Anchored& anchored = found->second;
        require_depth(where(mark), anchored.height);
        count_values(where(mark), anchored.values);
        YamlNode node = anchored.node;
        node.where = where(mark);
        attach({std::move(node), anchored.values, anchored.height}, 0);
    }

    void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  const std::string& value) override {
        require_no_tag(mark, tag);
        YamlNode node;
        node.kind = YamlNode::Kind::scalar;
        node.text = value;
        node.quoted = tag == "!";
        node.where = where(mark);
        add(std::move(node), anchor);
    }

    void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                         YAML::EmitterStyle::value) override {
        open(mark, tag, anchor, YamlNode::Kind::list);
    }
    void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                    YAML::EmitterStyle::value) override {
        open(mark, tag, anchor, YamlNode::Kind::map);
    }
    void OnSequenceEnd() override { close(); }
    void OnMapEnd() override { close(); }

private:
    /// A finished value, how many values it holds with itself, how many levels it nests.
    struct Anchored {
        YamlNode node;
        std::size_t values = 1;
        int height = 0;
    };
    /// A list or map whose end was not seen yet.
    struct Open {
        Anchored value;
        YAML::anchor_t anchor = 0;
        bool has_key = false;  // a map's key waits for its value
        std::string key;
        YamlWhere key_where;
        std::unordered_map<std::string, YamlWhere> keys;
    };

    void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
              YamlNode::Kind kind) {
        require_no_tag(mark, tag);
        require_depth(where(mark), 1);
        if (!open_.empty())
            require_not_key(open_.back(), where(mark), "a list or map, is a bracket left open?");
        count_values(where(mark), 1);
        Open level;
        level.value.node.kind = kind;
        level.value.node.where = where(mark);
        level.value.height = 1;
        level.anchor = anchor;
        open_.push_back(std::move(level));
    }

    void close() {
        Open level = std::move(open_.back());
        open_.pop_back();
        attach(std::move(level.value), level.anchor);
    }

    void add(YamlNode node, YAML::anchor_t anchor) {
        count_values(node.where, 1);
        attach({std::move(node)}, anchor);
    }

    /// Puts a finished value where the document has it: root, list item, key, or value of a key.
    void attach(Anchored value, YAML::anchor_t anchor) {
        if (anchor != 0) {
            count_values(value.node.where, value.values);  // the copy takes memory as well
            anchors_[anchor] = value;
        }
        if (open_.empty()) {
            root_ = std::move(value.node);
            return;
        }
        Open& parent = open_.back();
        if (parent.value.node.kind == YamlNode::Kind::map && !parent.has_key) {
            take_key(parent, value.node);
            return;
        }
        parent.value.values += value.values;
        parent.value.height = std::max(parent.value.height, value.height + 1);
        if (parent.value.node.kind == YamlNode::Kind::list) {
            parent.value.node.items.push_back(std::move(value.node));
        } else {
            parent.value.node.entries.push_back(
                {std::move(parent.key), parent.key_where, std::move(value.node)});
            parent.has_key = false;
        }
    }

    void take_key(Open& map, YamlNode& key) {
        if (key.kind != YamlNode::Kind::scalar) require_not_key(map, key.where, describe(key));
        const auto [first, is_new] = map.keys.emplace(key.text, key.where);
        if (!is_new)
            fail_at(key.where, printable(key.text),
                    "given twice, first at " + first->second.text());
        map.has_key = true;
        map.key = std::move(key.text);
        map.key_where = key.where;
    }

    void require_not_key(const Open& parent, const YamlWhere& place, const std::string& got) const {
        if (parent.value.node.kind == YamlNode::Kind::map && !parent.has_key)
            fail_at(place, "", "expected a key, got " + got);
    }

    void require_no_tag(const YAML::Mark& mark, const std::string& tag) const {
        // yaml-cpp says "?" for a plain value and "!" for one in quotes.
        if (!tag.empty() && tag != "?" && tag != "!")
            fail_at(where(mark), "", fmt::format("expected no tag, got '{}'", printable(tag)));
    }

    void require_depth(const YamlWhere& place, int height) const {
        if (static_cast<int>(open_.size()) + height > kMaxDepth)
            fail_at(place, "", fmt::format("lists and maps nest more than {} deep", kMaxDepth));
    }

    void count_values(const YamlWhere& place, std::size_t more) {
        values_ += more;
        if (values_ > kMaxValues)
            fail_at(place, "", fmt::format("more than {} values, aliases expanded", kMaxValues));
    }

    std::shared_ptr<const std::string> source_;
    bool is_flag_;
    bool started_ = false;
    YamlNode root_;
    std::vector<Open> open_;
    std::map<YAML::anchor_t, Anchored> anchors_;
    std::size_t values_ = 0;
};

YamlNode parse(std::string_view text, const std::string& source, bool is_flag) {
    TreeBuilder builder(std::make_shared<const std::string>(source), is_flag);
    std::istringstream stream{std::string(text)};
    try {
        YAML::Parser parser(stream);
        if (!parser.HandleNextDocument(builder))
            fail_at(builder.where(YAML::Mark()), "", "expected a value, got nothing");
        parser.HandleNextDocument(builder);  // refused by the builder if there is one
    } catch (const YAML::Exception& error) {
        fail_at(builder.where(error.mark), "", "wrong YAML: " + printable(error.msg));
    }
    return builder.take();
}

struct FileCloser {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

[[noreturn]] void fail_to_read(const std::filesystem::path& file) {
    const int reason = errno;
    throw InputError(fmt::format("{}: cannot be read: {}", file.string(), std::strerror(reason)));
}

/// Streams do not say why they failed, and read a directory as an empty file; stdio does neither.
std::string read_text(const std::filesystem::path& file) {
    const std::unique_ptr<std::FILE, FileCloser> input(std::fopen(file.c_str(), "rb"));
    if (!input) fail_to_read(file);
    std::string text;
    std::vector<char> chunk(std::size_t{1} << 16);
    while (const std::size_t got = std::fread(chunk.data(), 1, chunk.size(), input.get())) {
        text.append(chunk.data(), got);
        if (text.size() > kMaxBytes)
            throw InputError(fmt::format("{}: larger than {} MiB, which no scene needs",
                                         file.string(), kMaxBytes >> 20));
    }
    if (std::ferror(input.get())) fail_to_read(file);
    return text;
}

}  // namespace

std::string YamlWhere::text() const {
    return is_flag() ? *source : fmt::format("{}:{}:{}", *source, line, column);
}

void fail_at(const YamlWhere& where, std::string_view key, std::string_view message) {
    const std::string place = where.text();
    const bool named =
        key.empty() || (where.is_flag() && (place.ends_with(fmt::format(".{}", key)) ||
                                            place.ends_with(fmt::format(" {}", key))));
    const std::string text = named ? fmt::format("{}: {}", place, message)
                                   : fmt::format("{}: {}: {}", place, key, message);
    if (where.is_flag()) throw UsageError(text);
    throw InputError(text);
}

std::string printable(std::string_view text) {
    constexpr std::size_t kMaxLength = 60;  // chosen: a message stays on one line of a terminal
    std::string result(text.substr(0, kMaxLength));
    for (char& c : result)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return text.size() > kMaxLength ? result + "..." : result;
}

std::string describe(const YamlNode& node) {
    switch (node.kind) {
        case YamlNode::Kind::null:
            return "nothing";
        case YamlNode::Kind::scalar:
            return fmt::format("{}'{}'", node.quoted ? "the text " : "", printable(node.text));
        case YamlNode::Kind::list:
            return node.items.empty() ? "an empty list"
                                      : fmt::format("a list of {}", node.items.size());
        case YamlNode::Kind::map:
            return node.entries.empty() ? "an empty map" : "a map";
    }
    return "";
}

YamlNode parse_yaml(std::string_view text, const std::string& name) {
    return parse(text, name, false);
}

YamlNode parse_yaml_flag(std::string_view text, const std::string& flag) {
    return parse(text, flag, true);
}

YamlNode read_yaml(const std::filesystem::path& file) {
    return parse_yaml(read_text(file), file.string());
}

}  // namespace tallow
