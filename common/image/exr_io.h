// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/image/image.h"

namespace tallow {

/// Writes all channels as 32-bit floats, ZIP-compressed, with the metadata as string attributes,
/// under `name.tmp`, then renames. Channels of a layer are "layer.R"; "R", "G", "B", "A" are the
/// picture. Throws OutputError.
void write_exr(const std::filesystem::path& file, const Image& image);

/// Reads every channel of a scan-line or tiled EXR as float, channels in alphabetical order, string
/// attributes as metadata. Throws InputError for files that are damaged, have several parts, deep
/// or subsampled channels, or claim more pixels than a file of their size can hold.
Image read_exr(const std::filesystem::path& file);

}  // namespace tallow
