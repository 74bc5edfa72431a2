// SPDX-License-Identifier: Apache-2.0
// Frame and state -> text over the picture.
#include "viewer/overlay.h"

#include <fmt/format.h>

#include "viewer/picture.h"

namespace tallow {
namespace {

std::string accuracy_line(const ViewFrame& frame) {
    if (frame.certified)
        return fmt::format("certified {:g} %, largest bound {:.2g} %", 100 * frame.tolerance,
                           100 * frame.largest_bound);
    return fmt::format("tolerance {:g} %, no bound (6 certifies)", 100 * frame.tolerance);
}

std::string shown_line(const ViewState& state) {
    const std::string name(aov_name(state.aov()));
    switch (state.aov()) {
        case Aov::error:
            return name + ": bound, black 0 to white at the tolerance";
        case Aov::evaluations:
            return fmt::format("{}: black 1 to white {:g} a ray", name, kMostEvaluations);
        default:
            return fmt::format("{}, {:+.1f} stops", name, state.exposure());
    }
}

}  // namespace

std::vector<std::string> overlay_lines(const ViewFrame& frame, const ViewState& state) {
    const std::string samples =
        frame.draft ? "draft"
                    : fmt::format("{} of {} samples", frame.samples, frame.wanted_samples);
    std::vector<std::string> lines = {
        fmt::format("{:.0f} ms, {} x {}, {}", frame.milliseconds, frame.camera.width,
                    frame.camera.height, samples),
        fmt::format("{} shading points", frame.shading_points),
        accuracy_line(frame),
        shown_line(state),
    };
    if (const std::string group = state.selected_group(); !group.empty())
        lines.push_back("light " + group);
    if (const std::string material = state.selected_material(); !material.empty())
        lines.push_back(material);
    return lines;
}

std::vector<std::string> help_lines() {
    return {
        "W A S D   move",
        "Q E       down, up",
        "Shift     faster",
        "wheel     speed",
        "right     mouse button turns",
        "left      mouse button orbits",
        "          around the point under it",
        "1 ... 7   beauty, multiple, single,",
        "          specular, exitance, error,",
        "          evaluations",
        "[ ]       exposure",
        ", .       tolerance",
        "L + -     light group, intensity",
        "M         preset of the material",
        "Shift+M   its model",
        "Ctrl+M    next material",
        "F12       screenshot",
        "H         this help",
        "Escape    close",
    };
}

}  // namespace tallow
