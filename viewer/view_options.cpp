// SPDX-License-Identifier: Apache-2.0
#include "viewer/view_options.h"

#include <fmt/format.h>

#include <cmath>

#include "common/base/errors.h"
#include "render/find_camera.h"
#include "render/frame_range.h"

namespace tallow {
namespace {

constexpr double kSmallestTolerance = 1e-4;  // as of certificates, which key 6 asks for

}  // namespace

void declare(CommandLine& line, ViewOptions& options) {
    line.positional("SCENE", options.scene, "Scene file (YAML or JSON)");
    line.path("--cache", options.cache,
              "Cache file made by tallow-precompute; made there if there is none, or if the scene "
              "has changed [default: SCENE with the extension .tallow]");
    line.text("--camera", options.camera, "Camera to start with [default: the scene's first]",
              "NAME");
    line.number("--tolerance", options.tolerance, kSmallestTolerance, std::nextafter(1.0, 0.0),
                "a number in [1e-4, 1)",
                "Accepted relRMSE of the hierarchical sum, to start with [default: the scene's, or "
                "0.01]");
    line.integer("--samples", options.samples, 1, 65536, "an integer in [1, 65536]",
                 "Camera rays a pixel when nothing moves [default: the scene's, or 16]");
    line.path("--screenshots", options.screenshots,
              "Folder where F12 writes [default: the current one]");
    line.path("--log", options.log, "Write a line for each frame (CSV), times in ms");
    line.integer(
        "--frames", options.frames, 1, 1000000, "an integer in [1, 1000000]",
        "Open no window: render so many frames, 1/30 s apart, with the events of --script");
    line.path("--script", options.script, "Keys and mouse for --frames (YAML, docs/VIEWER.md)");
    line.text("-o,--output", options.output,
              "With --frames: write each frame, .png as shown or .exr with layers; #### becomes "
              "its number",
              "IMAGE_####.png|.exr");
    line.text_list("--set", options.overrides,
                   "Override a value of the scene, e.g. groups.key.scale=2", "KEY=VALUE");
}

void require_consistent(const ViewOptions& options) {
    if (options.script && !options.frames)
        throw UsageError("--script: expected --frames beside it, got none");
    if (options.output.empty()) return;
    const std::filesystem::path output = options.output;
    if (!options.frames) throw UsageError("--output: expected --frames beside it, got none");
    if (output.extension() != ".png" && output.extension() != ".exr")
        throw UsageError(fmt::format("--output: expected a name ending in .exr or .png, got '{}'",
                                     output.string()));
    if (*options.frames > 1 && !has_frame_field(output))
        throw UsageError(
            fmt::format("--output: expected a name with #### for the number of the frame, as "
                        "in turn_####.png, got '{}'",
                        output.string()));
}

Camera first_camera(const ViewOptions& options, const Scene& scene) {
    return camera_at(find_camera(scene, options.camera), 0);
}

std::filesystem::path cache_file(const ViewOptions& options) {
    if (options.cache) return *options.cache;
    return std::filesystem::path(options.scene).replace_extension(".tallow");
}

}  // namespace tallow
