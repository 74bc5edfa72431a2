// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string_view>

namespace tallow {

/// Reads numbers from the bytes of a mesh file; never past their end.
class ByteCursor {
public:
    /// `bytes` must outlive the cursor. `order` is the byte order of the file.
    ByteCursor(std::string_view bytes, std::endian order) : left_(bytes), order_(order) {}

    std::size_t left() const { return left_.size(); }

    /// The next T, or false and nothing read if the bytes do not suffice.
    template <class T>
    bool read(T& value) {
        if (left_.size() < sizeof(T)) return false;
        std::array<char, sizeof(T)> raw;
        std::memcpy(raw.data(), left_.data(), sizeof(T));
        if (order_ != std::endian::native) std::reverse(raw.begin(), raw.end());
        std::memcpy(&value, raw.data(), sizeof(T));
        left_.remove_prefix(sizeof(T));
        return true;
    }

    bool skip(std::size_t bytes) {
        if (left_.size() < bytes) return false;
        left_.remove_prefix(bytes);
        return true;
    }

private:
    std::string_view left_;
    std::endian order_;
};

}  // namespace tallow
