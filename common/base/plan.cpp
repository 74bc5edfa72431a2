// SPDX-License-Identifier: Apache-2.0
#include "common/base/plan.h"

#include <fmt/format.h>

namespace tallow {

std::string plan_text(const Plan& plan) {
    std::string text;
    for (const Decision& d : plan.decisions) {
        text += fmt::format("{:<24} {:<20} {:<9} {}; {}", d.subject, d.term,
                            d.computed ? "computed" : "left out", d.how, d.because);
        if (d.bound) text += fmt::format(" (bound {:.2g})", *d.bound);
        text += '\n';
    }
    for (const auto& [name, value] : plan.numbers)
        text += fmt::format("{:<24} {:.6g}\n", name, value);
    return text;
}

}  // namespace tallow
