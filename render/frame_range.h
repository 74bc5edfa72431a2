// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "common/scene/camera.h"

namespace tallow {

/// Frames of a moving camera, both included.
struct FrameRange {
    int first, last;
    bool has_many() const { return last > first; }
};

/// Reads "7" or "0-35". Throws UsageError.
FrameRange parse_frames(const std::string& text);

/// Refuses frames that a camera does not have. Throws UsageError.
void require_frames(const Camera& camera, FrameRange frames);

/// Whether the name of a file (not that of its folder) has a place for the number of a frame: a run
/// of '#'.
bool has_frame_field(const std::filesystem::path& file);

/// The file with the number in place of each run of '#', with at least as many digits: frame 7 of
/// turn_####.exr is turn_0007.exr.
std::filesystem::path frame_file(const std::filesystem::path& file, int frame);

}  // namespace tallow
