// SPDX-License-Identifier: Apache-2.0
// Command lines over CLI11. CLI11 only splits arguments and prints help; repeated flags, unknown
// arguments and values are judged here, so that every message has our form.
#include "common/base/cli.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <functional>

#include "common/base/errors.h"
#include "common/base/parse_whole.h"

namespace tallow {
namespace {

constexpr int kMaxThreads = 1024;  // chosen: more than any machine has, fewer than exhaust one

// What CLI11 gives an option that may stand alone, and does.
constexpr const char* kNoValue = "true";

[[noreturn]] void refuse(const std::string& name, const std::string& expected,
                         const std::string& text) {
    throw UsageError(fmt::format("{}: expected {}, got '{}'", name, expected, text));
}

int parse_integer(const std::string& name, const std::string& text, int low, int high,
                  const std::string& range) {
    const auto value = parse_whole<int>(text);
    if (!value || *value < low || *value > high) refuse(name, range, text);
    return *value;
}

/// Refuses "--out --quiet", which would write a file of that name.
void require_text(const std::string& name, const std::string& text, const std::string& type_name) {
    if (text.empty() || text.starts_with("--")) refuse(name, type_name, text);
}

}  // namespace

double parse_number(const std::string& name, const std::string& text, double low, double high,
                    const std::string& range) {
    const auto value = parse_whole<double>(text);
    if (!value || !std::isfinite(*value) || *value < low || *value > high)
        refuse(name, range, text);
    return *value;
}

struct CommandLine::Impl {
    struct Binding {
        CLI::Option* option;
        bool repeatable;
        std::function<void(const std::string& name, const std::string& text)> set;
    };

    CLI::App app;
    std::vector<Binding> bindings;

    explicit Impl(const std::string& tool, const std::string& description)
        : app(description, tool) {
        app.allow_extras();  // collected by CLI11, refused in reject_extras()
        app.get_formatter()->column_width(36);
    }

    /// Adds an option of one value; `set` is called for each value after the whole line was read.
    CLI::Option* bind(const std::string& name, const std::string& help, decltype(Binding::set) set,
                      bool repeatable = false) {
        CLI::Option* option = app.add_option(
            name, [](const CLI::results_t&) { return true; }, help);
        option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)->allow_extra_args(false);
        bindings.push_back({option, repeatable, std::move(set)});
        return option;
    }

    void reject_extras() const {
        for (const std::string& extra : app.remaining()) {
            if (extra == "--") continue;  // ends the flags; CLI11 lists it all the same
            throw UsageError(extra.starts_with('-') && extra.size() > 1
                                 ? fmt::format("unknown flag '{}', see --help", extra)
                                 : fmt::format("unexpected argument '{}', see --help", extra));
        }
    }

    void set_values() const {
        for (const Binding& binding : bindings) {
            const std::string name = binding.option->get_name();
            if (!binding.repeatable && binding.option->count() > 1)
                throw UsageError(fmt::format("{}: given {} times", name, binding.option->count()));
            for (const std::string& text : binding.option->results()) binding.set(name, text);
        }
    }
};

CommandLine::CommandLine(const std::string& tool, const std::string& description)
    : impl_(std::make_unique<Impl>(tool, description)) {
    impl_->app.set_version_flag("--version", tool + " " TALLOW_VERSION,
                                "Print the version and exit");
}

CommandLine::~CommandLine() = default;

void CommandLine::positional(const std::string& name, std::filesystem::path& value,
                             const std::string& help, bool required) {
    impl_
        ->bind(name, help,
               [&value](const std::string& key, const std::string& text) {
                   require_text(key, text, "FILE");
                   value = text;
               })
        ->type_name("FILE")
        ->required(required);
}

void CommandLine::flag(const std::string& name, bool& value, const std::string& help) {
    CLI::Option* option = impl_->app.add_flag(name, help);
    option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    impl_->bindings.push_back(
        {option, false, [&value](const std::string& key, const std::string& text) {
             if (text != "true")
                 throw UsageError(fmt::format("{}: takes no value, got '{}'", key, text));
             value = true;
         }});
}

void CommandLine::text(const std::string& name, std::string& value, const std::string& help,
                       const std::string& type_name) {
    impl_
        ->bind(name, help,
               [&value, type_name](const std::string& key, const std::string& text) {
                   require_text(key, text, type_name);
                   value = text;
               })
        ->type_name(type_name)
        ->default_str(value);
}

void CommandLine::optional_text(const std::string& name, std::optional<std::string>& value,
                                const std::string& help, const std::string& type_name) {
    impl_
        ->bind(name, help,
               [&value](const std::string&, const std::string& text) {
                   value = text == kNoValue ? "" : text;
               })
        ->type_name("[" + type_name + "]")
        ->expected(0, 1);
}

void CommandLine::text_list(const std::string& name, std::vector<std::string>& value,
                            const std::string& help, const std::string& type_name) {
    const bool repeatable = true;
    impl_
        ->bind(
            name, help + "; may be repeated",
            [&value, type_name](const std::string& key, const std::string& text) {
                require_text(key, text, type_name);
                value.push_back(text);
            },
            repeatable)
        ->type_name(type_name);
}

void CommandLine::path(const std::string& name, std::optional<std::filesystem::path>& value,
                       const std::string& help) {
    impl_
        ->bind(name, help,
               [&value](const std::string& key, const std::string& text) {
                   require_text(key, text, "FILE");
                   value = text;
               })
        ->type_name("FILE")
        ->default_str(value ? value->string() : "");
}

void CommandLine::number(const std::string& name, std::optional<double>& value, double low,
                         double high, const std::string& range, const std::string& help) {
    impl_
        ->bind(name, fmt::format("{}; {}", help, range),
               [&value, low, high, range](const std::string& key, const std::string& text) {
                   value = parse_number(key, text, low, high, range);
               })
        ->type_name("NUMBER")
        ->default_str(value ? fmt::format("{}", *value) : "");
}

void CommandLine::integer(const std::string& name, std::optional<int>& value, int low, int high,
                          const std::string& range, const std::string& help) {
    impl_
        ->bind(name, fmt::format("{}; {}", help, range),
               [&value, low, high, range](const std::string& key, const std::string& text) {
                   value = parse_integer(key, text, low, high, range);
               })
        ->type_name("INTEGER")
        ->default_str(value ? fmt::format("{}", *value) : "");
}

void CommandLine::add_common(CommonOptions& options) {
    const std::string range = fmt::format("an integer in [1, {}]", kMaxThreads);
    impl_
        ->bind("--threads", "threads to use; " + range,
               [&options, range](const std::string& key, const std::string& text) {
                   options.threads = parse_integer(key, text, 1, kMaxThreads, range);
               })
        ->type_name("INTEGER")
        ->default_str("all");
    flag("-q,--quiet", options.quiet, "Print nothing but errors");
    path("--stats", options.stats, "Write a JSON summary of the run (times in seconds)");
}

bool CommandLine::parse(int argc, const char* const* argv) {
    try {
        impl_->app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        fmt::print("{}", impl_->app.help());
        return false;
    } catch (const CLI::CallForVersion& version) {
        fmt::print("{}\n", version.what());
        return false;
    } catch (const CLI::ArgumentMismatch&) {
        // An option takes whatever follows it, so only the last argument can lack its value.
        throw UsageError(fmt::format("{}: missing value", argv[argc - 1]));
    } catch (const CLI::ParseError& error) {
        impl_->reject_extras();  // the mistyped argument is the likelier cause of a missing one
        throw UsageError(error.what());
    }
    impl_->reject_extras();
    impl_->set_values();
    return true;
}

}  // namespace tallow
