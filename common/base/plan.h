// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tallow {

/// Whether one term of one thing in the scene is computed, and why.
struct Decision {
    std::string subject;  // "materials.marble", "objects[1]", "scene"
    std::string term;     // "single scattering"
    bool computed;
    std::string how;              // "32 depths a pixel", "as a diffuse surface"
    std::string because;          // "forced", or what the bound says
    std::optional<double> bound;  // largest relative error of the picture, where something is
                                  // left out by a bound
};

/// What a program is about to do: told to people, and recorded by --stats. docs/PLAN.md derives the
/// bounds.
struct Plan {
    std::vector<Decision> decisions;
    std::map<std::string, double> numbers;  // "samples", "memory_bytes", "predicted_seconds"
};

/// One line a decision and a number, each ended by '\n'.
std::string plan_text(const Plan& plan);

}  // namespace tallow
