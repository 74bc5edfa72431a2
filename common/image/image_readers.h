// SPDX-License-Identifier: Apache-2.0
#pragma once

// Behind read_image: readers of bytes that may be hostile.

#include <cstdint>
#include <string>
#include <string_view>

#include "common/image/read_image.h"

namespace tallow {

/// Chosen: 8k x 8k pixels, 0.8 GB; the largest environments in use are 16k x 4k or 8k x 4k.
inline constexpr std::uint64_t kMaxImagePixels = std::uint64_t{1} << 26;
inline constexpr std::uint32_t kMaxImageSide = 1 << 16;  // pixels

/// Throws InputError unless 1 to kMaxImageSide pixels a side and kMaxImagePixels altogether are
/// claimed, and `bytes` of a file can hold them at `most_per_byte` pixels each.
void require_image_size(const std::string& name, std::int64_t width, std::int64_t height,
                        std::uint64_t bytes, std::uint64_t most_per_byte);

// Both throw InputError that begins with `name` for what they cannot decode whole.
RgbImage decode_png(const std::string& name, std::string_view bytes);
RgbImage decode_hdr(const std::string& name, std::string_view bytes);

}  // namespace tallow
