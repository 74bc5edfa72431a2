// SPDX-License-Identifier: Apache-2.0
// Radiance HDR bytes -> linear pixels: a text header, then rows of four bytes a pixel (three
// mantissas and their common exponent), plain or in one of two run-length encodings.
//
// Source: Ward 1991, "Real Pixels", Graphics Gems II; the format's description in Radiance's
// manual "The Radiance Picture File Format".
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>

#include "common/base/errors.h"
#include "common/base/parse_whole.h"
#include "common/image/image_readers.h"

namespace tallow {
namespace {

using Rgbe = std::array<std::uint8_t, 4>;

// Chosen: a row of one colour and the largest width is 16 bytes of old runs.
constexpr std::uint64_t kMostPixelsPerByte = kMaxImageSide / 16;

class HdrReader {
public:
    HdrReader(const std::string& name, std::string_view bytes)
        : name_(name), left_(bytes), size_(bytes.size()) {}

    RgbImage read() {
        read_header();
        read_size();
        RgbImage image{width_, height_, {}};
        std::vector<Rgbe> row(std::size_t(width_), Rgbe{});
        // Grows with what is decoded, not with what is claimed.
        for (int y = 0; y < height_; ++y) {
            read_row(y, row);
            for (const Rgbe& pixel : row) image.pixels.push_back(decode(pixel));
        }
        if (!left_.empty()) fail(fmt::format("{} bytes too many behind the pixels", left_.size()));
        return image;
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(fmt::format("{}: not a readable Radiance HDR image: {}", name_, what));
    }

    std::string_view next_line() {
        const std::size_t end = left_.find('\n');
        if (end == std::string_view::npos) fail("ends within the header");
        const std::string_view line = left_.substr(0, end);
        left_.remove_prefix(end + 1);
        return line;
    }

    void read_header() {
        if (!next_line().starts_with("#?")) fail("expected it to begin with '#?'");
        bool has_format = false;
        for (std::string_view line = next_line(); !line.empty(); line = next_line()) {
            if (line.starts_with("FORMAT=")) {
                if (line != "FORMAT=32-bit_rle_rgbe") fail("expected FORMAT=32-bit_rle_rgbe");
                has_format = true;
            } else if (line.starts_with("EXPOSURE=")) {
                line.remove_prefix(9);
                while (line.starts_with(' ')) line.remove_prefix(1);
                const auto exposure = parse_whole<double>(line);
                if (!exposure || !(*exposure > 1e-30 && *exposure < 1e30))
                    fail("expected a number > 0 as EXPOSURE");
                exposure_ *= *exposure;
            }
        }
        if (!has_format) fail("expected FORMAT=32-bit_rle_rgbe");
    }

    void read_size() {
        const std::string_view line = next_line();
        const std::size_t x = line.find(" +X ");
        const bool plain = line.starts_with("-Y ") && x != std::string_view::npos;
        const auto height = plain ? parse_whole<int>(line.substr(3, x - 3)) : std::nullopt;
        const auto width = plain ? parse_whole<int>(line.substr(x + 4)) : std::nullopt;
        if (!width || !height) fail("expected a size '-Y HEIGHT +X WIDTH'");
        require_image_size(name_, *width, *height, size_, kMostPixelsPerByte);
        width_ = *width;
        height_ = *height;
    }

    std::uint8_t next_byte(int y) {
        if (left_.empty()) fail(fmt::format("ends in row {} of {}", y, height_));
        const auto byte = std::uint8_t(left_.front());
        left_.remove_prefix(1);
        return byte;
    }

    void read_row(int y, std::vector<Rgbe>& row) {
        Rgbe first;
        for (std::uint8_t& byte : first) byte = next_byte(y);
        const bool by_component =
            width_ >= 8 && width_ < 32768 && first[0] == 2 && first[1] == 2 && first[2] < 128;
        if (!by_component) return read_old_row(y, first, row);
        if (256 * first[2] + first[3] != width_) fail(fmt::format("row {}: wrong width", y));
        for (std::size_t component = 0; component < 4; ++component) {
            for (std::size_t x = 0; x < row.size();) {
                const std::uint8_t code = next_byte(y);
                const bool is_run = code > 128;
                const std::size_t count = is_run ? code - 128u : code;
                if (count == 0 || count > row.size() - x)
                    fail(fmt::format("row {}: wrong length of a run", y));
                const std::uint8_t value = is_run ? next_byte(y) : std::uint8_t{0};
                for (const std::size_t end = x + count; x < end; ++x)
                    row[x][component] = is_run ? value : next_byte(y);
            }
        }
    }

    /// Pixels, of which (1, 1, 1, n) stands for n repetitions of the one before; further ones right
    /// behind it count 256 times as much each.
    void read_old_row(int y, Rgbe pixel, std::vector<Rgbe>& row) {
        std::uint64_t unit = 1;  // repetitions a count
        for (std::size_t x = 0;;) {
            if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
                const std::uint64_t count = pixel[3] * unit;
                if (x == 0 || count > row.size() - x)
                    fail(fmt::format("row {}: wrong length of a run", y));
                for (const std::size_t end = x + count; x < end; ++x) row[x] = row[x - 1];
                unit = std::min<std::uint64_t>(256 * unit, kMaxImageSide);
            } else {
                row[x++] = pixel;
                unit = 1;
            }
            if (x == row.size()) return;
            for (std::uint8_t& byte : pixel) byte = next_byte(y);
        }
    }

    /// (mantissa + 1/2) 2^(exponent - 136) / exposure: writers cut digits off, so half a step is
    /// what they lose on average. Exponent 0 is black.
    Rgb decode(const Rgbe& pixel) const {
        if (pixel[3] == 0) return {};
        const double scale = std::ldexp(1.0, pixel[3] - 136) / exposure_;
        return {float((pixel[0] + 0.5) * scale), float((pixel[1] + 0.5) * scale),
                float((pixel[2] + 0.5) * scale)};
    }

    const std::string& name_;
    std::string_view left_;
    std::size_t size_;
    double exposure_ = 1;  // stored over true radiance
    int width_ = 0, height_ = 0;
};

}  // namespace

RgbImage decode_hdr(const std::string& name, std::string_view bytes) {
    return HdrReader(name, bytes).read();
}

}  // namespace tallow
