// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/vec.h"

namespace tallow {

/// Takes the text of a mesh file apart into words, line by line. Line ends are LF or CRLF; numbers
/// are parsed whole ("1.5x" is not 1.5) and must be finite. All complaints are InputError
/// "file: line 7: expected <what>, got 'word'".
class TextScanner {
public:
    /// `text` must outlive the scanner. `comment` starts one that lasts to the end of its line;
    /// '\0' if the format has none.
    TextScanner(std::string file, std::string_view text, char comment);

    /// Moves to the next line that holds a word; false at the end of the file.
    bool next_line();
    void require_line(std::string_view what);

    /// Next word of this line; empty at its end.
    std::string_view next_word();
    std::string_view word(std::string_view what);
    float number(std::string_view what);
    Vec3 vector(std::string_view what);
    std::int64_t integer(std::string_view what);
    /// A number of things that are still to come, each at least `bytes_each` bytes long: what the
    /// rest of the file cannot hold is refused before anybody allocates it.
    std::size_t count(std::string_view things, std::size_t bytes_each);
    /// A vertex index counted from zero.
    std::uint32_t index();

    bool at_end_of_line() const { return words_.empty(); }
    void expect_end_of_line();
    void expect_end_of_file();
    /// The words left on this line must be numbers (colours, weights) and are skipped.
    void skip_numbers();

    /// The text behind this line.
    std::string_view rest() const { return text_.substr(next_); }
    std::size_t line() const { return line_; }

    [[noreturn]] void fail(const std::string& message) const { fail_at(line_, message); }
    [[noreturn]] void fail_at(std::size_t line, const std::string& message) const;
    [[noreturn]] void fail_expected(std::string_view what, std::string_view got) const;

private:
    void skip_space();

    std::string file_;
    std::string_view text_;
    char comment_;
    std::size_t next_ = 0;    // start of the next line
    std::string_view words_;  // what is left of this line
    std::size_t line_ = 0;    // as editors count, from one
};

/// Parses the whole of `word`; false for anything else or a value that is no finite float.
bool parse_float(std::string_view word, float& value);
bool parse_integer(std::string_view word, std::int64_t& value);

/// `word` as users may see it: in quotes, unprintable bytes replaced, shortened.
std::string in_quotes(std::string_view word);

}  // namespace tallow
