// SPDX-License-Identifier: Apache-2.0
// Fingerprints and group names as the text that a cache holds, and the comparison of fingerprints.
#include "common/cloud/fingerprint_text.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>

#include "common/base/check.h"
#include "common/base/errors.h"
#include "common/cloud/cache_io.h"

namespace tallow {
namespace {

constexpr std::size_t kLongestShown = 120;  // characters of a value in a message

const std::string* find_value(const Fingerprint& fingerprint, const std::string& key) {
    const auto found = std::find_if(fingerprint.begin(), fingerprint.end(),
                                    [&](const auto& pair) { return pair.first == key; });
    return found == fingerprint.end() ? nullptr : &found->second;
}

bool wants_indirect_light(const Fingerprint& scene) {
    const std::string* bounces = find_value(scene, "indirect.bounces");
    return bounces != nullptr && *bounces != "0";
}

/// At most kLongestShown characters of `value`, such that the one at `difference` is among them.
std::string shorten(const std::string& value, std::size_t difference) {
    if (value.size() <= kLongestShown) return value;
    const std::size_t start = std::min(difference - std::min(difference, kLongestShown / 2),
                                       value.size() - kLongestShown);
    const bool cut_end = start + kLongestShown < value.size();
    return (start > 0 ? "..." : "") + value.substr(start, kLongestShown) + (cut_end ? "..." : "");
}

[[noreturn]] void fail_mismatch(const std::filesystem::path& file, const std::string& key,
                                const std::string* made_from, const std::string* needed) {
    std::size_t difference = 0;
    if (made_from && needed)
        difference = static_cast<std::size_t>(
            std::mismatch(made_from->begin(), made_from->end(), needed->begin(), needed->end())
                .first -
            made_from->begin());
    const auto shown = [&](const std::string* value) {
        return value ? shorten(*value, difference) : std::string("nothing");
    };
    const bool indirect = key.starts_with("indirect.");
    throw InputError(fmt::format(
        "{}: {}made from {} = {}, but the scene has {}; re-run tallow-precompute{}", file.string(),
        indirect ? "indirect light was " : "", key, shown(made_from), shown(needed),
        indirect ? ", which keeps the direct light, or do without with --set settings.bounces=0"
                 : ""));
}

}  // namespace

std::string encode_lines(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) {
        TALLOW_CHECK(line.find('\n') == std::string::npos, "'{}'", line);
        text += line + '\n';
    }
    return text;
}

std::optional<std::vector<std::string>> decode_lines(std::string_view text) {
    std::vector<std::string> lines;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        if (end == std::string_view::npos) return std::nullopt;
        lines.emplace_back(text.substr(0, end));
        text.remove_prefix(end + 1);
    }
    return lines;
}

std::string encode_fingerprint(const Fingerprint& fingerprint) {
    std::vector<std::string> lines;
    for (const auto& [key, value] : fingerprint) {
        TALLOW_CHECK(key.find('=') == std::string::npos, "'{}'", key);
        lines.push_back(key + '=' + value);
    }
    return encode_lines(lines);
}

std::optional<Fingerprint> decode_fingerprint(std::string_view text) {
    const auto lines = decode_lines(text);
    if (!lines) return std::nullopt;
    Fingerprint fingerprint;
    for (const std::string& line : *lines) {
        const std::size_t equals = line.find('=');
        if (equals == std::string::npos) return std::nullopt;
        fingerprint.emplace_back(line.substr(0, equals), line.substr(equals + 1));
    }
    return fingerprint;
}

void require_fingerprint(const std::filesystem::path& cache_file, const Fingerprint& cache,
                         const Fingerprint& scene) {
    const bool indirect = wants_indirect_light(scene);
    const auto is_compared = [indirect](const std::string& key) {
        return !key.starts_with("sampling.") && (indirect || !key.starts_with("indirect."));
    };
    for (const auto& [key, value] : cache) {
        if (!is_compared(key)) continue;
        const std::string* needed = find_value(scene, key);
        if (!needed || *needed != value) fail_mismatch(cache_file, key, &value, needed);
    }
    for (const auto& [key, value] : scene)
        if (is_compared(key) && !find_value(cache, key))
            fail_mismatch(cache_file, key, nullptr, &value);
}

std::string fingerprint_id(const Fingerprint& fingerprint) {
    const std::string text = encode_fingerprint(fingerprint);
    return fmt::format("{:016x}", XXH3_64bits(text.data(), text.size()));
}

}  // namespace tallow
