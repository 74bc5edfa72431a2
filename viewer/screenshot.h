// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "common/image/image.h"
#include "viewer/view_frame.h"
#include "viewer/view_state.h"

namespace tallow {

/// The frame as an image with all layers that it has.
Image frame_image(const ViewFrame& frame);

/// Writes what is shown to NAME.png, the same frame with all its layers to NAME.exr, and its camera
/// to NAME.yaml, where NAME is that of the scene's file with the first number that is free:
/// folder/bunny_0001. Returns folder/NAME. Throws OutputError.
std::filesystem::path save_screenshot(const std::filesystem::path& folder, const Scene& scene,
                                      const ViewFrame& frame, const ViewState& state,
                                      const decltype(Image::metadata)& metadata);

/// Writes the frame as the name's extension says: .png as it is shown, .exr with its layers.
void write_frame(const std::filesystem::path& file, const ViewFrame& frame, const ViewState& state,
                 const decltype(Image::metadata)& metadata);

}  // namespace tallow
