// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tallow {

/// Flags that every tool has.
struct CommonOptions {
    int threads = 0;  ///< 0: all that the machine has
    bool quiet = false;
    std::optional<std::filesystem::path> stats;
};

/// Our thin layer over CLI11: typed flags whose values are parsed whole ("1.5mm" is not 1.5, nor
/// is "0.5" an integer), finite and in range, or UsageError says which flag wanted what. The help
/// text shows units and defaults: a variable's value before parsing is its default. Each call binds
/// a variable that must outlive parsing; names are "--output" or "-o,--output". Only text_list()
/// may be given more than once.
class CommandLine {
public:
    CommandLine(const std::string& tool, const std::string& description);
    ~CommandLine();

    void positional(const std::string& name, std::filesystem::path& value, const std::string& help,
                    bool required = true);
    void flag(const std::string& name, bool& value, const std::string& help);
    void text(const std::string& name, std::string& value, const std::string& help,
              const std::string& type_name = "TEXT");
    /// A flag whose value may be left out: then it is the empty text.
    void optional_text(const std::string& name, std::optional<std::string>& value,
                       const std::string& help, const std::string& type_name);
    void text_list(const std::string& name, std::vector<std::string>& value,
                   const std::string& help, const std::string& type_name = "TEXT");
    void path(const std::string& name, std::optional<std::filesystem::path>& value,
              const std::string& help);
    /// `range` is told to users: "a number > 0".
    void number(const std::string& name, std::optional<double>& value, double low, double high,
                const std::string& range, const std::string& help);
    void integer(const std::string& name, std::optional<int>& value, int low, int high,
                 const std::string& range, const std::string& help);

    /// Adds --threads, --quiet, --stats, --version.
    void add_common(CommonOptions& options);

    /// Parses. Returns false if --help or --version was asked for and has been printed on stdout.
    /// Throws UsageError.
    bool parse(int argc, const char* const* argv);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Parses the whole of `text` as a finite number in [low, high], or throws UsageError
/// "--name: expected <range>, got '<text>'".
double parse_number(const std::string& name, const std::string& text, double low, double high,
                    const std::string& range);

}  // namespace tallow
