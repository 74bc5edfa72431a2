// SPDX-License-Identifier: Apache-2.0
// PNG bytes -> linear pixels. Through libpng's full interface: the simplified one multiplies 16-bit
// colours with their alpha. It reports errors by a jump, so between setjmp and the jump there is
// nothing here that would need a destructor.
#include <fmt/format.h>
#include <png.h>

#include <array>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstring>

#include "common/base/check.h"
#include "common/base/errors.h"
#include "common/image/image_readers.h"
#include "common/image/png_io.h"

namespace tallow {
namespace {

constexpr std::uint64_t kMostPixelsPerByte = 1032 * 8;  // deflate's best ratio, pixels of 1 bit

using Message = std::array<char, 160>;

[[noreturn]] void on_error(png_structp png, png_const_charp text) {
    auto* message = static_cast<Message*>(png_get_error_ptr(png));
    std::snprintf(message->data(), message->size(), "%s", text);
    png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep out, size_t count) {
    auto* left = static_cast<std::string_view*>(png_get_io_ptr(png));
    if (count > left->size()) png_error(png, "ends early");
    std::memcpy(out, left->data(), count);
    left->remove_prefix(count);
}

class PngReader {
public:
    explicit PngReader(std::string_view bytes) : left_(bytes) {
        png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &message_, on_error, on_warning);
        info_ = png_ ? png_create_info_struct(png_) : nullptr;
        if (!info_) {
            png_destroy_read_struct(&png_, nullptr, nullptr);
            throw std::bad_alloc();
        }
        png_set_read_fn(png_, &left_, on_read);
        png_set_user_limits(png_, kMaxImageSide, kMaxImageSide);
    }
    ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;

    /// Everything before the pixels; asks for R, G, B of 8 or 16 bits. False on errors.
    bool read_header() {
        if (setjmp(png_jmpbuf(png_))) return false;
        png_read_info(png_, info_);
        png_set_palette_to_rgb(png_);
        png_set_expand_gray_1_2_4_to_8(png_);
        png_set_gray_to_rgb(png_);
        png_set_strip_alpha(png_);
        png_set_interlace_handling(png_);
        png_read_update_info(png_, info_);
        return true;
    }

    bool read_rows(png_bytep* rows) {
        if (setjmp(png_jmpbuf(png_))) return false;
        png_read_image(png_, rows);
        png_read_end(png_, nullptr);
        return true;
    }

    std::uint32_t width() const { return png_get_image_width(png_, info_); }
    std::uint32_t height() const { return png_get_image_height(png_, info_); }
    std::size_t row_bytes() const { return png_get_rowbytes(png_, info_); }
    bool has_16_bits() const { return png_get_bit_depth(png_, info_) == 16; }

    /// Exponent from light to stored values, or 0 for the sRGB curve: that of a file that says
    /// nothing, and of the power 1/2.2, which is how many programs write sRGB.
    double gamma() const {
        double gamma = 0;
        if (png_get_valid(png_, info_, PNG_INFO_sRGB) || !png_get_gAMA(png_, info_, &gamma) ||
            !(gamma > 0) || std::abs(gamma * 2.2 - 1) < 0.05)
            return 0;
        return gamma;
    }

    const char* message() const { return message_.data(); }

private:
    std::string_view left_;
    Message message_{};
    png_structp png_ = nullptr;
    png_infop info_ = nullptr;
};

/// Linear values of all stored ones.
std::vector<float> decoding_table(bool has_16_bits, double gamma) {
    std::vector<float> table(has_16_bits ? 65536 : 256);
    for (std::size_t i = 0; i < table.size(); ++i) {
        const double stored = double(i) / double(table.size() - 1);
        table[i] = gamma > 0 ? float(std::pow(stored, 1 / gamma)) : srgb_decode(float(stored));
    }
    return table;
}

}  // namespace

RgbImage decode_png(const std::string& name, std::string_view bytes) {
    PngReader reader(bytes);
    const auto fail = [&] {
        throw InputError(fmt::format("{}: not a readable PNG image: {}", name, reader.message()));
    };
    if (!reader.read_header()) fail();
    const std::size_t width = reader.width(), height = reader.height();
    require_image_size(name, std::int64_t(width), std::int64_t(height), bytes.size(),
                       kMostPixelsPerByte);
    const std::size_t value_bytes = reader.has_16_bits() ? 2 : 1;
    TALLOW_CHECK(reader.row_bytes() == 3 * width * value_bytes, "{} bytes in a row of {}",
                 reader.row_bytes(), width);
    std::vector<png_byte> stored(reader.row_bytes() * height);
    std::vector<png_bytep> rows(height);
    for (std::size_t y = 0; y < height; ++y) rows[y] = &stored[y * reader.row_bytes()];
    if (!reader.read_rows(rows.data())) fail();

    const std::vector<float> linear = decoding_table(reader.has_16_bits(), reader.gamma());
    RgbImage image{int(width), int(height), std::vector<Rgb>(width * height)};
    for (std::size_t i = 0; i < 3 * image.pixels.size(); ++i) {
        const std::size_t value =
            value_bytes == 2 ? 256u * stored[2 * i] + stored[2 * i + 1] : stored[i];
        image.pixels[i / 3][int(i % 3)] = linear[value];
    }
    return image;
}

}  // namespace tallow
