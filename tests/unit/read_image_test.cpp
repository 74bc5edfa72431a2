// SPDX-License-Identifier: Apache-2.0
// Images as textures and environments read them, from files written by the libraries themselves or
// byte by byte.
#include "common/image/read_image.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include "common/base/errors.h"
#include "common/base/vec.h"
#include "common/image/exr_io.h"
#include "common/image/png_io.h"
#include "tests/support/error_text.h"
#include "tests/support/test_files.h"

namespace tallow {
namespace {

/// The message without the file's folder, or "no error".
std::string image_error(const std::filesystem::path& file) {
    const std::string text = error_text<InputError>([&] { read_image(file); });
    const std::string folder = file.parent_path().string() + "/";
    if (text.empty()) return "no error";
    EXPECT_EQ(text.find(folder), 0u) << text;
    return text.substr(std::min(text.size(), folder.size()));
}

std::string error_of_bytes(const std::string& name, const std::string& bytes) {
    write_bytes(test_out(name), bytes);
    return image_error(test_out(name));
}

RgbImage image_of_bytes(const std::string& name, const std::string& bytes) {
    write_bytes(test_out(name), bytes);
    return read_image(test_out(name));
}

/// Flips bits of `seed` and cuts some copies short; counts how many are refused. All must be
/// refused with InputError or read.
int refused_mutants(const std::string& name, const std::string& seed, int count) {
    std::mt19937 random(11);
    const auto below = [&](std::size_t n) { return random() % n; };
    int refused = 0;
    for (int i = 0; i < count; ++i) {
        std::string bytes = seed;
        for (std::size_t flips = 1 + below(3); flips > 0; --flips)
            bytes[below(bytes.size())] ^= static_cast<char>(1u << below(8));
        if (i % 10 == 0) bytes.resize(below(bytes.size()));
        refused += error_of_bytes(name, bytes) != "no error";
    }
    return refused;
}

// ------------------------------------------------------------------------------------------- EXR

Image exr_of(const std::vector<std::string>& channels, int width = 3, int height = 2) {
    Image image = make_image(width, height);
    float next = 0.25f;
    for (const std::string& name : channels)
        for (float& v : image.add_channel(name)) v = next++;
    return image;
}

std::string error_of_exr(const Image& image) {
    write_exr(test_out("a.exr"), image);
    return image_error(test_out("a.exr"));
}

TEST(ReadImage, ExrChannels) {
    write_exr(test_out("rgb.exr"), exr_of({"R", "G", "B", "A", "Z"}));
    const RgbImage rgb = read_image(test_out("rgb.exr"));
    ASSERT_EQ(rgb.width, 3);
    ASSERT_EQ(rgb.height, 2);
    EXPECT_EQ(rgb.at(0, 0), Rgb(0.25f, 6.25f, 12.25f));
    EXPECT_EQ(rgb.at(2, 1), Rgb(5.25f, 11.25f, 17.25f));
    write_exr(test_out("grey.EXR"), exr_of({"Y"}));
    EXPECT_EQ(read_image(test_out("grey.EXR")).at(1, 0), Rgb(1.25f));
}

TEST(ReadImage, ExrRefusals) {
    EXPECT_EQ(error_of_exr(exr_of({"G", "Z"})),
              "a.exr: expected channels R, G and B, or Y alone, got G, Z");
    Image crop = make_image(9, 9);
    crop.crop_width = 4;
    for (const char* name : {"R", "G", "B"}) crop.add_channel(name);
    EXPECT_EQ(error_of_exr(crop), "a.exr: expected a whole image, got a crop of one");
    for (const float bad : {-0.5f, NAN, kInfinity}) {
        Image image = exr_of({"R", "G", "B"});
        image.channels[2].values[4] = bad;
        EXPECT_EQ(
            error_of_exr(image).find("a.exr: pixel (1, 1): expected finite numbers >= 0, got"), 0u)
            << bad;
    }
    EXPECT_EQ(image_error(test_out("lost.exr")), "lost.exr: no such file");
    EXPECT_EQ(error_of_bytes("text.exr", "unit: mm\n").find("text.exr: not a readable OpenEXR"),
              0u);
}

TEST(ReadImage, OtherFiles) {
    EXPECT_EQ(error_of_bytes("sky.jpg", "x"),
              "sky.jpg: expected an image file .exr, .hdr or .png, got '.jpg'");
    EXPECT_EQ(image_error(test_out("lost.png")), "lost.png: no such file");
    EXPECT_EQ(error_of_bytes("empty.hdr", ""), "empty.hdr: expected an image, got an empty file");
    std::filesystem::create_directories(test_out("folder.png"));
    EXPECT_EQ(image_error(test_out("folder.png")),
              "folder.png: expected a file, got a directory or device");
}

// ------------------------------------------------------------------------------------------- PNG

struct PngFile {
    int width = 3, height = 2, bits = 8, color_type = PNG_COLOR_TYPE_RGB;
    std::vector<png_byte> rows;  // as libpng takes them
    double gamma = 0;            // the gAMA chunk, or none
    bool interlaced = false;
};

std::string encode_png(const PngFile& file) {
    std::string bytes;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(
        png, &bytes,
        [](png_structp p, png_bytep data, size_t n) {
            static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(data), n);
        },
        nullptr);
    png_set_IHDR(png, info, png_uint_32(file.width), png_uint_32(file.height), file.bits,
                 file.color_type, file.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    const png_color palette[2] = {{255, 0, 0}, {0, 0, 255}};
    const png_byte transparency[2] = {0, 128};
    if (file.color_type == PNG_COLOR_TYPE_PALETTE) {
        png_set_PLTE(png, info, palette, 2);
        png_set_tRNS(png, info, transparency, 2, nullptr);
    }
    if (file.gamma > 0) png_set_gAMA(png, info, file.gamma);
    png_write_info(png, info);
    std::vector<png_bytep> rows;
    const std::size_t stride = file.rows.size() / std::size_t(file.height);
    std::vector<png_byte> copy = file.rows;
    for (int y = 0; y < file.height; ++y) rows.push_back(&copy[std::size_t(y) * stride]);
    png_write_image(png, rows.data());
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    return bytes;
}

PngFile ramp_png() {
    PngFile file;
    for (int i = 0; i < 3 * 3 * 2; ++i) file.rows.push_back(png_byte(14 * i));
    return file;
}

TEST(ReadImage, Png8Bits) {
    PngFile file = ramp_png();
    for (const bool interlaced : {false, true}) {
        file.interlaced = interlaced;
        const RgbImage image = image_of_bytes("a.png", encode_png(file));
        ASSERT_EQ(image.pixels.size(), 6u);
        for (int i = 0; i < 18; ++i)
            EXPECT_EQ(image.pixels[std::size_t(i / 3)][i % 3], srgb_decode(float(14 * i) / 255));
    }
}

// IEC 61966-2-1, computed in double; and the inverse of what we write.
TEST(ReadImage, SrgbIsMadeLinear) {
    EXPECT_EQ(srgb_decode(0), 0);
    EXPECT_EQ(srgb_decode(1), 1);
    EXPECT_NEAR(srgb_decode(0.5f), 0.2140411f, 1e-6f);
    EXPECT_NEAR(srgb_decode(0.04f), 0.0030960f, 1e-7f);
    for (float v = 0; v <= 1; v += 0.01f)
        EXPECT_NEAR(srgb_decode(srgb_encode(v)), v, 1e-6f);  // measured 2e-7
}

TEST(ReadImage, Png16BitsWithAlphaKeepItsColours) {
    PngFile file{2, 1, 16, PNG_COLOR_TYPE_RGB_ALPHA, {}};
    for (const unsigned v : {1u, 65535u, 32768u, 0u, 700u, 0u, 9u, 65535u})
        file.rows.insert(file.rows.end(), {png_byte(v >> 8), png_byte(v)});
    const RgbImage image = image_of_bytes("a.png", encode_png(file));
    EXPECT_EQ(image.at(0, 0), Rgb(srgb_decode(1 / 65535.0f), 1, srgb_decode(32768 / 65535.0f)));
    EXPECT_EQ(image.at(1, 0), Rgb(srgb_decode(700 / 65535.0f), 0, srgb_decode(9 / 65535.0f)));
}

TEST(ReadImage, PngGreyAndPalette) {
    const PngFile grey{8, 1, 1, PNG_COLOR_TYPE_GRAY, {0b01000000}};
    const RgbImage bits = image_of_bytes("grey.png", encode_png(grey));
    EXPECT_EQ(bits.at(0, 0), Rgb(0));
    EXPECT_EQ(bits.at(1, 0), Rgb(1));
    const PngFile grey_alpha{1, 1, 8, PNG_COLOR_TYPE_GRAY_ALPHA, {255, 0}};
    EXPECT_EQ(image_of_bytes("ga.png", encode_png(grey_alpha)).at(0, 0), Rgb(1));
    const PngFile palette{8, 1, 1, PNG_COLOR_TYPE_PALETTE, {0b01000000}};
    const RgbImage colours = image_of_bytes("palette.png", encode_png(palette));
    EXPECT_EQ(colours.at(0, 0), Rgb(1, 0, 0));
    EXPECT_EQ(colours.at(1, 0), Rgb(0, 0, 1));
}

TEST(ReadImage, PngGamma) {
    PngFile file{1, 1, 8, PNG_COLOR_TYPE_RGB, {128, 0, 255}};
    file.gamma = 1;
    EXPECT_NEAR(image_of_bytes("a.png", encode_png(file)).at(0, 0).r, 128 / 255.0f, 1e-6f);
    file.gamma = 1 / 2.2;
    EXPECT_EQ(image_of_bytes("a.png", encode_png(file)).at(0, 0).r, srgb_decode(128 / 255.0f));
}

TEST(ReadImage, PngTruncatedOrMutated) {
    const std::string seed = encode_png(ramp_png());
    for (std::size_t size = 1; size < seed.size(); ++size)
        ASSERT_EQ(
            error_of_bytes("cut.png", seed.substr(0, size)).find("cut.png: not a readable PNG"), 0u)
            << size;
    EXPECT_GT(refused_mutants("fuzz.png", seed, 500), 400);  // measured 500: every byte is checked
}

TEST(ReadImage, PngHugeClaim) {
    PngFile file{40000, 1, 8, PNG_COLOR_TYPE_GRAY, std::vector<png_byte>(40000)};
    std::string bytes = encode_png(file);  // 40000 x 1; now claim 40000 x 40000 with a right CRC
    const std::size_t ihdr = bytes.find("IHDR");
    bytes[ihdr + 10] = char(40000 >> 8), bytes[ihdr + 11] = char(40000 & 255);
    std::uint32_t crc = 0xffffffff;
    for (std::size_t i = ihdr; i < ihdr + 17; ++i) {
        crc ^= std::uint8_t(bytes[i]);
        for (int k = 0; k < 8; ++k) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0);
    }
    for (std::size_t i = 0; i < 4; ++i) bytes[ihdr + 17 + i] = char(~crc >> (24 - 8 * i));
    EXPECT_EQ(
        error_of_bytes("huge.png", bytes),
        "huge.png: expected 1 to 65536 pixels a side and at most 67108864 in all, got 40000 x "
        "40000");
}

// ------------------------------------------------------------------------------------------- HDR

using Rgbe = std::array<std::uint8_t, 4>;

std::string hdr_header(int width, int height, const std::string& lines = "") {
    return "#?RADIANCE\n" + lines + "FORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) +
           " +X " + std::to_string(width) + "\n";
}

void append(std::string& bytes, std::initializer_list<int> more) {
    for (const int byte : more) bytes.push_back(char(byte));
}

Rgb rgbe_value(Rgbe p) {
    return map(Rgb(p[0], p[1], p[2]),
               [&](float m) { return std::ldexp(m + 0.5f, int(p[3]) - 136); });
}

TEST(ReadImage, HdrPlainAndOldRuns) {
    std::string bytes = hdr_header(4, 2);
    append(bytes, {128, 64, 32, 129, 1, 1, 1, 3});                            // one and three more
    append(bytes, {5, 6, 7, 120, 9, 9, 9, 0, 128, 0, 0, 200, 1, 2, 1, 130});  // four plain ones
    const RgbImage image = image_of_bytes("a.hdr", bytes);
    for (int x = 0; x < 4; ++x) EXPECT_EQ(image.at(x, 0), rgbe_value({128, 64, 32, 129}));
    EXPECT_EQ(image.at(0, 1), rgbe_value({5, 6, 7, 120}));
    EXPECT_EQ(image.at(1, 1), Rgb(0));
    EXPECT_EQ(image.at(2, 1), rgbe_value({128, 0, 0, 200}));
    EXPECT_EQ(image.at(3, 1), rgbe_value({1, 2, 1, 130}));
    EXPECT_NEAR(image.at(0, 0).r, 1, 0.004f);  // half a step of 1/128
}

TEST(ReadImage, HdrLongOldRun) {
    std::string bytes = hdr_header(1000, 1);
    append(bytes, {7, 8, 9, 128, 1, 1, 1, 231, 1, 1, 1, 3});  // 1 + 231 + 3 * 256 = 1000
    const RgbImage image = image_of_bytes("a.hdr", bytes);
    EXPECT_EQ(image.at(999, 0), rgbe_value({7, 8, 9, 128}));
}

std::string hdr_with_new_runs() {
    std::string bytes = hdr_header(9, 2, "# made by hand\nEXPOSURE= 2\nEXPOSURE=0.25\n");
    for (int y = 0; y < 2; ++y) {
        append(bytes, {2, 2, 0, 9});
        append(bytes, {128 + 9, 100 + y});                 // R: a run of nine
        append(bytes, {9, 1, 2, 3, 4, 5, 6, 7, 8, 9});     // G: nine values
        append(bytes, {128 + 4, 50, 2, 60, 61, 131, 70});  // B: four, two values, three
        append(bytes, {128 + 9, 130});                     // E
    }
    return bytes;
}

TEST(ReadImage, HdrNewRunsAndExposure) {
    const RgbImage image = image_of_bytes("a.hdr", hdr_with_new_runs());
    const int blue[9] = {50, 50, 50, 50, 60, 61, 70, 70, 70};
    for (int x = 0; x < 9; ++x) {
        const Rgbe stored{101, std::uint8_t(x + 1), std::uint8_t(blue[x]), 130};
        EXPECT_EQ(image.at(x, 1), 2.0f * rgbe_value(stored)) << x;
    }
}

TEST(ReadImage, HdrRefusals) {
    const std::string pixel(4, '\7');
    const auto message = [](const std::string& bytes) {
        const std::string text = error_of_bytes("a.hdr", bytes);
        const std::string start = "a.hdr: not a readable Radiance HDR image: ";
        return text.starts_with(start) ? text.substr(start.size()) : text;
    };
    EXPECT_EQ(message("P6\n"), "expected it to begin with '#?'");
    EXPECT_EQ(message("#?RADIANCE\nFORMAT=32-bit_rle_rgbe"), "ends within the header");
    EXPECT_EQ(message("#?RADIANCE\n\n-Y 1 +X 1\n"), "expected FORMAT=32-bit_rle_rgbe");
    EXPECT_EQ(message("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n"), "expected FORMAT=32-bit_rle_rgbe");
    EXPECT_EQ(message(hdr_header(1, 1, "EXPOSURE=0\n") + pixel),
              "expected a number > 0 as EXPOSURE");
    for (const char* size : {"+X 1 -Y 1", "-Y 1 +X 1x", "-Y 1", "-Y  1 +X 1", "+Y 1 +X 1"})
        EXPECT_EQ(message("#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n" + std::string(size) + "\n" + pixel),
                  "expected a size '-Y HEIGHT +X WIDTH'")
            << size;
    EXPECT_EQ(message(hdr_header(1, 2) + pixel), "ends in row 1 of 2");
    EXPECT_EQ(message(hdr_header(1, 1) + pixel + "\n"), "1 bytes too many behind the pixels");
    EXPECT_EQ(message(hdr_header(2, 1) + pixel + "\1\1\1\2"), "row 0: wrong length of a run");
    EXPECT_EQ(message(hdr_header(2, 1) + "\1\1\1\2"), "row 0: wrong length of a run");
    EXPECT_EQ(message(hdr_header(9, 1) + std::string("\2\2\0\10", 4)), "row 0: wrong width");
    EXPECT_EQ(message(hdr_header(9, 1) + std::string("\2\2\0\11\0", 5)),
              "row 0: wrong length of a run");
    EXPECT_EQ(message(hdr_header(65536, 60000) + pixel),
              "a.hdr: expected 1 to 65536 pixels a side and at most 67108864 in all, got 65536 x "
              "60000");
    EXPECT_EQ(message(hdr_header(0, 1)),
              "a.hdr: expected 1 to 65536 pixels a side and at most 67108864 in all, got 0 x 1");
    EXPECT_EQ(message(hdr_header(8000, 8000) + pixel),
              "a.hdr: claims 8000 x 8000 pixels, more than 55 bytes can hold");
    EXPECT_EQ(message(hdr_header(1, 1, "EXPOSURE=1e-29\n") + "\377\377\377\377"),
              "a.hdr: pixel (0, 0): expected finite numbers >= 0, got inf");
}

TEST(ReadImage, HdrTruncatedOrMutated) {
    const std::string seed = hdr_with_new_runs();
    for (std::size_t size = 1; size < seed.size(); ++size)
        ASSERT_NE(error_of_bytes("cut.hdr", seed.substr(0, size)), "no error") << size;
    EXPECT_GT(refused_mutants("fuzz.hdr", seed, 1000), 500);  // measured 695
}

}  // namespace
}  // namespace tallow
