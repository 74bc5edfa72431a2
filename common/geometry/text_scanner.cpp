// SPDX-License-Identifier: Apache-2.0
//
// Text in, words and numbers out. One pass, no copies: words are views into the file's text.

#include "common/geometry/text_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "common/base/errors.h"

namespace tallow {

namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

/// std::from_chars knows no plus sign, mesh files do.
std::string_view without_plus(std::string_view word) {
    const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
    return plus ? word.substr(1) : word;
}

template <class T>
bool parse_whole(std::string_view word, T& value) {
    word = without_plus(word);
    const char* end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    return error == std::errc() && stop == end;
}

}  // namespace

bool parse_float(std::string_view word, float& value) {
    double wide;  // so that 1e-50 is a small number, and not an error
    if (!parse_whole(word, wide)) return false;
    value = static_cast<float>(wide);
    return std::isfinite(value);
}

bool parse_integer(std::string_view word, std::int64_t& value) { return parse_whole(word, value); }

std::string in_quotes(std::string_view word) {
    constexpr std::size_t kLongest = 40;
    std::string text(word.substr(0, kLongest));
    for (char& c : text)
        if (c < ' ' || c > '~') c = '?';
    return "'" + text + (word.size() > kLongest ? "...'" : "'");
}

TextScanner::TextScanner(std::string file, std::string_view text, char comment)
    : file_(std::move(file)), text_(text), comment_(comment) {}

bool TextScanner::next_line() {
    while (next_ < text_.size()) {
        const std::size_t end = std::min(text_.find('\n', next_), text_.size());
        words_ = text_.substr(next_, end - next_);
        next_ = std::min(end + 1, text_.size());
        ++line_;
        skip_space();
        if (!words_.empty()) return true;
    }
    words_ = {};
    return false;
}

void TextScanner::require_line(std::string_view what) {
    if (!next_line()) fail_expected(what, "the end of the file");
}

/// Leaves words_ empty or beginning with a word.
void TextScanner::skip_space() {
    while (!words_.empty() && is_space(words_.front())) words_.remove_prefix(1);
    if (!words_.empty() && comment_ != '\0' && words_.front() == comment_) words_ = {};
}

std::string_view TextScanner::next_word() {
    std::size_t end = 0;
    while (end < words_.size() && !is_space(words_[end]) &&
           (comment_ == '\0' || words_[end] != comment_))
        ++end;
    const std::string_view word = words_.substr(0, end);
    words_.remove_prefix(end);
    skip_space();
    return word;
}

std::string_view TextScanner::word(std::string_view what) {
    const std::string_view word = next_word();
    if (word.empty()) fail_expected(what, "the end of the line");
    return word;
}

float TextScanner::number(std::string_view what) {
    const std::string_view text = word(what);
    float value;
    if (!parse_float(text, value)) fail_expected(what, in_quotes(text));
    return value;
}

Vec3 TextScanner::vector(std::string_view what) {
    const float x = number(what), y = number(what), z = number(what);
    return {x, y, z};
}

std::int64_t TextScanner::integer(std::string_view what) {
    const std::string_view text = word(what);
    std::int64_t value;
    if (!parse_integer(text, value)) fail_expected(what, in_quotes(text));
    return value;
}

std::size_t TextScanner::count(std::string_view things, std::size_t bytes_each) {
    const std::int64_t value = integer(fmt::format("a number of {}", things));
    if (value < 0) fail(fmt::format("expected a number of {}, got {}", things, value));
    // The last line may lack its line end.
    if (static_cast<std::size_t>(value) > (rest().size() + 1) / bytes_each)
        fail(fmt::format("{} {} do not fit in the {} bytes that follow", value, things,
                         rest().size()));
    return static_cast<std::size_t>(value);
}

std::uint32_t TextScanner::index() {
    const std::int64_t value = integer("a vertex index");
    if (value < 0 || value > std::numeric_limits<std::uint32_t>::max())
        fail_expected("a vertex index", fmt::format("{}", value));
    return static_cast<std::uint32_t>(value);
}

void TextScanner::expect_end_of_line() {
    if (!at_end_of_line()) fail_expected("the end of the line", in_quotes(next_word()));
}

void TextScanner::expect_end_of_file() {
    if (next_line()) fail_expected("the end of the file", in_quotes(next_word()));
}

void TextScanner::skip_numbers() {
    float ignored;
    for (auto word = next_word(); !word.empty(); word = next_word())
        if (!parse_float(word, ignored)) fail_expected("a number", in_quotes(word));
}

void TextScanner::fail_at(std::size_t line, const std::string& message) const {
    throw InputError(fmt::format("{}: line {}: {}", file_, line, message));
}

void TextScanner::fail_expected(std::string_view what, std::string_view got) const {
    fail(fmt::format("expected {}, got {}", what, got));
}

}  // namespace tallow
