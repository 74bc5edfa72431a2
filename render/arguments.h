// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/cli.h"
#include "common/exitance/sample_sum.h"
#include "common/scene/scene.h"
#include "render/frame_range.h"
#include "render/primary_hits.h"

namespace tallow {

/// The flags of tallow-render, as given.
struct Arguments {
    std::filesystem::path scene;
    std::optional<std::filesystem::path> cache;
    std::vector<std::string> outputs, overrides;
    std::string camera, frames, crop, aovs = "none", criterion = "error";
    std::optional<double> tolerance, certify, exposure;
    std::optional<int> samples;
    std::optional<std::string> preview;
    bool plan = false, everything = false;
};

void declare(CommandLine& line, Arguments& a);

// What single flags mean. All throw UsageError.

/// The tolerance is 0 if none is given.
ExitanceAccuracy parse_accuracy(const Arguments& a);

/// Names of layers. `all` leaves out the one that only a certificate can fill.
std::vector<std::string> parse_layers(const std::string& list, bool certified);

/// Pixels of the camera's image; all of them if the text is empty.
Tile parse_crop(const std::string& text, const Camera& camera);

/// What --frames asks for; nothing if it is not given.
std::optional<FrameRange> frames_of(const Arguments& a);

/// Refuses names that say no format, or that are the same for all frames.
void require_image_names(const Arguments& a);

}  // namespace tallow
