// SPDX-License-Identifier: Apache-2.0
// Images through EXR and PNG files and back, read by the libraries themselves where we only write.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/base/errors.h"
#include "common/base/vec.h"
#include "common/image/exr_io.h"
#include "common/image/png_io.h"
#include "tests/support/test_files.h"

namespace tallow {
namespace {

/// Sets a channel to start, start + 1, ... in the order of its pixels.
void fill_ramp(std::vector<float>& values, float start) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = start + static_cast<float>(i);
}

Image test_image() {
    Image image = make_image(7, 5);
    fill_ramp(image.add_channel("R"), -3.5f);
    fill_ramp(image.add_channel("multiple.G"), 1e-30f);
    fill_ramp(image.add_channel("Z"), 1e30f);
    image.metadata = {{"tallow:scene", "bunny.yaml"}, {"tallow:tolerance", "0.01"}};
    return image;
}

void expect_same_channels(const Image& a, const Image& b) {
    ASSERT_EQ(a.channels.size(), b.channels.size());
    for (const Channel& channel : a.channels) {
        const std::vector<float>* other = b.find_channel(channel.name);
        ASSERT_TRUE(other) << channel.name;
        EXPECT_EQ(channel.values, *other) << channel.name;
    }
}

std::string exr_error(const std::filesystem::path& file) {
    try {
        read_exr(file);
    } catch (const InputError& e) {
        return e.what();
    }
    return "no error";
}

TEST(Image, ChannelsCoverTheDataWindow) {
    Image image = make_image(7, 5);
    image.x0 = 2, image.y0 = 1, image.crop_width = 3, image.crop_height = 2;
    EXPECT_EQ(image.add_channel("A").size(), 6u);
    EXPECT_NE(image.find_channel("A"), nullptr);
    EXPECT_EQ(image.find_channel("B"), nullptr);
    EXPECT_THROW(image.add_channel("A"), std::logic_error);
}

TEST(Exr, RoundTripKeepsChannelsAndMetadata) {
    const Image image = test_image();
    write_exr(test_out("round_trip.exr"), image);
    const Image read = read_exr(test_out("round_trip.exr"));
    EXPECT_EQ(read.width, 7);
    EXPECT_EQ(read.height, 5);
    EXPECT_EQ(read.x0, 0);
    EXPECT_EQ(read.crop_width, 7);
    expect_same_channels(image, read);
    EXPECT_EQ(read.metadata, image.metadata);
    EXPECT_FALSE(std::filesystem::exists(test_out("round_trip.exr.tmp")));
}

TEST(Exr, RoundTripKeepsTheCropWindow) {
    Image image = make_image(70, 50);
    image.x0 = 12, image.y0 = 31, image.crop_width = 5, image.crop_height = 4;
    fill_ramp(image.add_channel("R"), 1);
    write_exr(test_out("crop.exr"), image);
    const Image read = read_exr(test_out("crop.exr"));
    EXPECT_EQ(read.width, 70);
    EXPECT_EQ(read.height, 50);
    EXPECT_EQ(read.x0, 12);
    EXPECT_EQ(read.y0, 31);
    EXPECT_EQ(read.crop_width, 5);
    EXPECT_EQ(read.crop_height, 4);
    expect_same_channels(image, read);
}

TEST(Exr, ReadsTiledHalfFloats) {
    std::vector<Imath::half> values(20 * 10);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
    Imf::Header header(20, 10);
    header.channels().insert("G", Imf::Channel(Imf::HALF));
    header.setTileDescription(Imf::TileDescription(8, 8));
    Imf::FrameBuffer buffer;
    buffer.insert("G", Imf::Slice(Imf::HALF, reinterpret_cast<char*>(values.data()), 2, 2 * 20));
    {
        Imf::TiledOutputFile file(test_out("tiled.exr").c_str(), header);
        file.setFrameBuffer(buffer);
        file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
    }
    const Image image = read_exr(test_out("tiled.exr"));
    ASSERT_TRUE(image.find_channel("G"));
    for (std::size_t i = 0; i < values.size(); ++i)
        ASSERT_EQ((*image.find_channel("G"))[i], static_cast<float>(i));
}

TEST(Exr, RefusesSubsampledChannels) {
    std::vector<float> values(4);
    Imf::Header header(4, 4);
    header.channels().insert("BY", Imf::Channel(Imf::FLOAT, 2, 2));
    Imf::FrameBuffer buffer;
    buffer.insert("BY", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 8, 2, 2));
    {
        Imf::OutputFile file(test_out("subsampled.exr").c_str(), header);
        file.setFrameBuffer(buffer);
        file.writePixels(4);
    }
    EXPECT_EQ(exr_error(test_out("subsampled.exr")),
              test_out("subsampled.exr").string() +
                  ": channel 'BY': expected one value a pixel, got a subsampled one");
}

TEST(Exr, RefusesWhatIsNoExr) {
    write_bytes(test_out("text.exr"), "unit: mm\n");
    write_bytes(test_out("empty.exr"), "");
    for (const auto& file :
         {test_out("text.exr"), test_out("empty.exr"), test_out("missing.exr"), test_out("")})
        EXPECT_EQ(exr_error(file).find(file.string() + ": not a readable OpenEXR image: "), 0u)
            << exr_error(file);
}

// The window claims 65536 x 65536 pixels: refused before memory is taken.
TEST(Exr, RefusesAHugeWindow) {
    write_exr(test_out("small.exr"), test_image());
    std::string bytes = read_bytes(test_out("small.exr"));
    const std::size_t window = bytes.find("dataWindow") + 11 + 6 + 4;  // name, "box2i", size
    const std::int32_t side[2] = {65535, 65535};
    std::copy_n(reinterpret_cast<const char*>(side), sizeof side, bytes.begin() + window + 8);
    write_bytes(test_out("huge.exr"), bytes);
    EXPECT_NE(exr_error(test_out("huge.exr")), "no error");
}

TEST(Exr, SurvivesMutation) {
    write_exr(test_out("fuzz_seed.exr"), test_image());
    const std::string seed = read_bytes(test_out("fuzz_seed.exr"));
    std::mt19937 random(7);
    const auto below = [&](std::size_t n) { return random() % n; };
    int refused = 0;
    for (int i = 0; i < 500; ++i) {
        std::string bytes = seed;
        for (std::size_t flips = 1 + below(3); flips > 0; --flips)
            bytes[below(bytes.size())] ^= static_cast<char>(1u << below(8));
        if (i % 10 == 0) bytes.resize(below(bytes.size()));
        write_bytes(test_out("fuzz.exr"), bytes);
        refused += exr_error(test_out("fuzz.exr")) != "no error";
    }
    EXPECT_GT(refused, 100);  // measured 425: the mutations do reach the reader
}

// The name of the temporary file is taken by a folder: nothing can be written, by root neither.
TEST(Exr, FailedWriteKeepsTheOldFile) {
    write_bytes(test_out("kept.exr"), "old");
    std::filesystem::create_directories(test_out("kept.exr.tmp"));
    EXPECT_THROW(write_exr(test_out("kept.exr"), test_image()), OutputError);
    EXPECT_EQ(read_bytes(test_out("kept.exr")), "old");
}

TEST(Exr, RefusesAnUnwritableFolder) {
    EXPECT_THROW(write_exr(test_out("no_such_folder") / "a.exr", test_image()), OutputError);
}

TEST(ToneMap, ChangesNothingUpToTheShoulder) {
    for (const Rgb c : {Rgb(0), Rgb(0.1f, 0.2f, 0.3f), Rgb(kShoulder, 0.5f, 0)})
        EXPECT_EQ(tone_map(c), c);
}

TEST(ToneMap, IsMonotoneInExposure) {
    Rgb last;
    for (float exposure = 0.01f; exposure < 1000; exposure *= 1.01f) {
        const Rgb mapped = tone_map(exposure * Rgb(1, 0.4f, 0.05f));
        for (int c = 0; c < 3; ++c) {
            EXPECT_GE(mapped[c], last[c]) << "channel " << c << " at " << exposure;
            EXPECT_LE(mapped[c], 1);
        }
        last = mapped;
    }
    EXPECT_GT(last.r, 0.999f);
}

// No kink at the shoulder: the slope there is 1 from both sides.
TEST(ToneMap, LeavesTheIdentitySmoothly) {
    const float step = 1e-3f;
    const float slope = (tone_map(Rgb(kShoulder + step)).r - kShoulder) / step;
    EXPECT_NEAR(slope, 1, 0.01f);  // measured 0.995
}

// Hue in the sense of HSV: where the middle channel lies between the others.
TEST(ToneMap, KeepsHue) {
    for (float exposure : {0.5f, 1.0f, 2.0f, 10.0f}) {
        const Rgb c = tone_map(exposure * Rgb(0.2f, 1, 0.6f));
        EXPECT_GT(c.g, c.b);
        EXPECT_GT(c.b, c.r);
        EXPECT_NEAR((c.g - c.b) / (c.g - c.r), 0.5f, 1e-4f) << exposure;
    }
}

TEST(ToneMap, GreyStaysGreyAndGlareTurnsWhite) {
    for (float level : {0.3f, 0.9f, 3.0f, 1e6f}) {
        const Rgb c = tone_map(Rgb(level));
        EXPECT_EQ(c.r, c.g);
        EXPECT_EQ(c.g, c.b);
    }
    EXPECT_GT(min_channel(tone_map({1e6f, 1e3f, 0})), 0.999f);
    EXPECT_EQ(tone_map({kInfinity, -1, NAN}).r, 1);
    EXPECT_EQ(tone_map({0.5f, -1, NAN}), Rgb(0.5f, 0, 0));
}

// Values of IEC 61966-2-1, computed in double.
TEST(Srgb, KnownValues) {
    EXPECT_EQ(srgb_encode(0), 0);
    EXPECT_EQ(srgb_encode(1), 1);
    EXPECT_EQ(srgb_encode(-1), 0);
    EXPECT_EQ(srgb_encode(2), 1);
    EXPECT_NEAR(srgb_encode(0.001f), 0.01292f, 1e-6f);
    EXPECT_NEAR(srgb_encode(0.0031308f), 0.0404499f, 1e-6f);
    EXPECT_NEAR(srgb_encode(0.18f), 0.4613561f, 1e-6f);
    EXPECT_NEAR(srgb_encode(0.5f), 0.7353570f, 1e-6f);
}

/// A PNG file as libpng decodes it: 8-bit R, G, B from the top left.
struct DecodedPng {
    int width = 0, height = 0;
    std::vector<std::uint8_t> pixels;
    const std::uint8_t* at(int x, int y) const { return &pixels[3 * (y * width + x)]; }
};

DecodedPng read_png(const std::filesystem::path& file) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    EXPECT_TRUE(png_image_begin_read_from_file(&png, file.c_str())) << png.message;
    EXPECT_EQ(png.format, static_cast<png_uint_32>(PNG_FORMAT_RGB));
    DecodedPng decoded{static_cast<int>(png.width), static_cast<int>(png.height), {}};
    decoded.pixels.resize(PNG_IMAGE_SIZE(png));
    EXPECT_TRUE(png_image_finish_read(&png, nullptr, decoded.pixels.data(), 0, nullptr));
    return decoded;
}

Image colour_image(int width, int height, Rgb colour) {
    Image image = make_image(width, height);
    for (int c = 0; c < 3; ++c) {
        auto& values = image.add_channel(std::string(1, "RGB"[c]));
        std::fill(values.begin(), values.end(), colour[c]);
    }
    return image;
}

// Dithering rounds up or down to the two neighbouring levels, and is right on average.
TEST(Png, DecodesToTheExpectedLevels) {
    const Rgb colour(0.1f, 0.5f, 0.02f);
    write_png(test_out("levels.png"), colour_image(64, 48, colour));
    const DecodedPng png = read_png(test_out("levels.png"));
    ASSERT_EQ(png.width, 64);
    ASSERT_EQ(png.height, 48);
    for (int c = 0; c < 3; ++c) {
        const double expected = 255.0 * srgb_encode(colour[c]);
        double sum = 0;
        for (int i = 0; i < 64 * 48; ++i) {
            ASSERT_LT(std::abs(png.pixels[3 * i + c] - expected), 1);
            sum += png.pixels[3 * i + c];
        }
        EXPECT_NEAR(sum / (64 * 48), expected, 0.005);  // measured 0.0005
    }
}

TEST(Png, BlackWhiteAndGreyStay) {
    Image image = colour_image(32, 32, Rgb(0));
    for (Channel& channel : image.channels) {
        channel.values[5] = 1e9f;
        std::fill(channel.values.begin() + 32, channel.values.end(), 0.3f);
    }
    write_png(test_out("white.png"), image);
    const DecodedPng png = read_png(test_out("white.png"));
    for (int x = 0; x < 32; ++x)
        for (int c = 0; c < 3; ++c) EXPECT_EQ(png.at(x, 0)[c], x == 5 ? 255 : 0);
    for (int y = 1; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
            EXPECT_EQ(png.at(x, y)[0], png.at(x, y)[1]);
            EXPECT_EQ(png.at(x, y)[1], png.at(x, y)[2]);
        }
}

TEST(Png, CropHoldsThePixelsOfTheWholeImage) {
    Image whole = make_image(40, 30), crop = whole;
    crop.x0 = 13, crop.y0 = 7, crop.crop_width = 10, crop.crop_height = 5;
    const auto value = [](int x, int y, int c) { return 0.01f * (x + 0.7f * y + 3 * c); };
    for (Image* image : {&whole, &crop})
        for (int c = 0; c < 3; ++c) {
            auto& values = image->add_channel(std::string(1, "RGB"[c]));
            for (std::size_t i = 0; i < values.size(); ++i) {
                const int x = image->x0 + static_cast<int>(i) % image->crop_width;
                const int y = image->y0 + static_cast<int>(i) / image->crop_width;
                values[i] = value(x, y, c);
            }
        }
    write_png(test_out("whole.png"), whole);
    write_png(test_out("crop.png"), crop);
    const DecodedPng a = read_png(test_out("whole.png")), b = read_png(test_out("crop.png"));
    ASSERT_EQ(b.width, 10);
    ASSERT_EQ(b.height, 5);
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 10; ++x)
            for (int c = 0; c < 3; ++c) EXPECT_EQ(a.at(13 + x, 7 + y)[c], b.at(x, y)[c]);
}

TEST(Png, ExposureIsInStops) {
    write_png(test_out("exposed.png"), colour_image(9, 9, {0.1f, 0.2f, 0.05f}), 1);
    write_png(test_out("doubled.png"), colour_image(9, 9, {0.2f, 0.4f, 0.1f}));
    EXPECT_EQ(read_bytes(test_out("exposed.png")), read_bytes(test_out("doubled.png")));
}

TEST(Png, FailedWriteKeepsTheOldFile) {
    write_bytes(test_out("kept.png"), "old");
    std::filesystem::create_directories(test_out("kept.png.tmp"));
    EXPECT_THROW(write_png(test_out("kept.png"), colour_image(2, 2, Rgb(1))), OutputError);
    EXPECT_EQ(read_bytes(test_out("kept.png")), "old");
}

}  // namespace
}  // namespace tallow
