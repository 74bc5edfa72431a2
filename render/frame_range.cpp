// SPDX-License-Identifier: Apache-2.0
// --frames and the names of the files of frames.
#include "render/frame_range.h"

#include <fmt/format.h>

#include "common/base/errors.h"
#include "common/base/parse_whole.h"

namespace tallow {
namespace {

std::optional<int> parse_frame(std::string_view text) {
    const auto frame = parse_whole<int>(text);
    return frame && *frame >= 0 ? frame : std::nullopt;
}

}  // namespace

FrameRange parse_frames(const std::string& text) {
    const std::size_t dash = text.find('-');
    const auto first = parse_frame(std::string_view(text).substr(0, dash));
    const auto last =
        dash == std::string::npos ? first : parse_frame(std::string_view(text).substr(dash + 1));
    if (!first || !last || *first > *last)
        throw UsageError(
            fmt::format("--frames: expected a frame A or frames A-B, 0 <= A <= B, got '{}'", text));
    return {*first, *last};
}

void require_frames(const Camera& camera, FrameRange frames) {
    if (std::holds_alternative<std::monostate>(camera.motion))
        throw UsageError(
            fmt::format("--frames: expected a camera with a turntable or keyframes, got '{}', "
                        "which does not move",
                        camera.name));
    if (frames.last >= frame_count(camera))
        throw UsageError(fmt::format("--frames: expected frames 0 to {} of camera '{}', got {}",
                                     frame_count(camera) - 1, camera.name, frames.last));
}

bool has_frame_field(const std::filesystem::path& file) {
    return file.filename().string().find('#') != std::string::npos;
}

std::filesystem::path frame_file(const std::filesystem::path& file, int frame) {
    const std::string name = file.filename().string();
    std::string numbered;
    for (std::size_t i = 0; i < name.size();) {
        const std::size_t digits = std::min(name.find_first_not_of('#', i), name.size()) - i;
        if (digits > 0)
            numbered += fmt::format("{:0{}}", frame, digits);
        else
            numbered += name[i];
        i += std::max<std::size_t>(digits, 1);
    }
    return std::filesystem::path(file).replace_filename(numbered);
}

}  // namespace tallow
