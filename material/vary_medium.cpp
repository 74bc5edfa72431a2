// SPDX-License-Identifier: Apache-2.0
#include "material/vary_medium.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "common/base/cli.h"
#include "common/base/errors.h"
#include "common/scene/presets.h"

namespace tallow {
namespace {

struct KnobRange {
    const char* key;
    Knob knob;
    double low, high;
    const char* text;
};
// Coefficients: from a mean free path of a kilometre to one of a picometre, as in scene files.
constexpr std::array<KnobRange, 5> kKnobs = {{
    {"sigma_a", Knob::sigma_a, 1e-6, 1e12, "a number of 1/mm >= 1e-6"},
    {"sigma_s_prime", Knob::sigma_s_prime, 1e-6, 1e12, "a number of 1/mm >= 1e-6"},
    {"eta", Knob::eta, 1, 3, "a relative index in [1, 3]"},
    {"g", Knob::g, -0.9999, 0.9999, "a number in [-0.9999, 0.9999]"},
    {"dilution", Knob::dilution, 1e-3, 1, "a share in [0.001, 1]"},
}};

const KnobRange& find_knob(const std::string& key) {
    for (const KnobRange& range : kKnobs)
        if (key == range.key) return range;
    throw UsageError(
        fmt::format("--vary: expected one of sigma_a, sigma_s_prime, eta, g, dilution, "
                    "got '{}'",
                    key));
}

/// Scales all channels so that their mean is `value`.
Rgb with_mean(Rgb coefficient, double value) {
    const double sum = double(coefficient.r) + double(coefficient.g) + double(coefficient.b);
    if (sum == 0) return Rgb(float(value));
    return coefficient * float(3 * value / sum);
}

}  // namespace

Variation parse_variation(const std::string& text) {
    const std::size_t equals = text.find('='), dots = text.find("..");
    if (equals == std::string::npos || dots == std::string::npos || dots < equals)
        throw UsageError(fmt::format("--vary: expected KEY=A..B, got '{}'", text));
    const KnobRange& range = find_knob(text.substr(0, equals));
    const auto number = [&](const std::string& part) {
        return parse_number("--vary", part, range.low, range.high, range.text);
    };
    return {range.knob, range.key, number(text.substr(equals + 1, dots - equals - 1)),
            number(text.substr(dots + 2))};
}

std::vector<double> variation_values(const Variation& v, int steps) {
    const bool linear = v.knob == Knob::eta || v.knob == Knob::g;
    std::vector<double> values;
    for (int i = 0; i < steps; ++i) {
        const double t = steps == 1 ? 0 : double(i) / (steps - 1);
        values.push_back(linear ? v.from + t * (v.to - v.from)
                                : v.from * std::pow(v.to / v.from, t));
    }
    return values;
}

Medium vary_medium(const Medium& medium, Knob knob, double value) {
    Medium varied = medium;
    switch (knob) {
        case Knob::sigma_a:
            varied.sigma_a = with_mean(medium.sigma_a, value);
            break;
        case Knob::sigma_s_prime:
            varied.sigma_s_prime = with_mean(medium.sigma_s_prime, value);
            break;
        case Knob::eta:
            varied.eta = float(value);
            break;
        case Knob::g:
            varied.g = float(value);
            break;
        case Knob::dilution:
            return diluted(medium, float(value));
    }
    return varied;
}

}  // namespace tallow
