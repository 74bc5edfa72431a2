// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/text_scanner.h"

namespace tallow {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::size_t size_in_bytes(PlyType type);

struct PlyProperty {
    std::string name;
    PlyType type;                       // of the value, or of each item of a list
    std::optional<PlyType> count_type;  // set for a list: the type of its length
};

struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;

    /// Index of a property, or nothing.
    std::optional<std::size_t> find(std::string_view property) const;
};

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };

/// What the first lines of a PLY file say about the rest. Counts are promises of the file: check
/// them against its size before they are believed.
struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
};

/// Reads up to the end of the line "end_header". Throws InputError.
PlyHeader read_ply_header(TextScanner& scan);

}  // namespace tallow
