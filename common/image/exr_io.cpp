// SPDX-License-Identifier: Apache-2.0
// Image <-> OpenEXR file. The only user of OpenEXR.
//
// Written in memory first: OpenEXR's file streams lose errors when they close, so that a full disk
// would leave a file that is cut short. Read with limits that are checked before memory is taken.
#include "common/image/exr_io.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfStdIO.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <cstdint>
#include <mutex>

#include "common/base/check.h"
#include "common/base/errors.h"
#include "common/base/output_file.h"

namespace tallow {
namespace {

// What a hostile file can make us allocate. Chosen: no compression of OpenEXR comes near
// kMaxValuesPerByte (a black picture in DWAA has 4000); kMaxValues is 8k x 8k pixels of 4 channels,
// 1 GiB.
constexpr int kMaxSide = 1 << 16;      // pixels
constexpr int kMaxTileSide = 1 << 12;  // pixels
constexpr std::uint64_t kMaxValuesPerByte = 1 << 14;
constexpr std::uint64_t kMaxValues = std::uint64_t{1} << 28;

Imath::Box2i data_window(const Image& image) {
    return {{image.x0, image.y0},
            {image.x0 + image.crop_width - 1, image.y0 + image.crop_height - 1}};
}

Imf::Header make_header(const Image& image) {
    const Imath::Box2i display({0, 0}, {image.width - 1, image.height - 1});
    Imf::Header header(display, data_window(image), 1, {0, 0}, 1, Imf::INCREASING_Y,
                       Imf::ZIP_COMPRESSION);
    for (const Channel& channel : image.channels)
        header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
    for (const auto& [key, value] : image.metadata) header.insert(key, Imf::StringAttribute(value));
    return header;
}

/// The image's channels as OpenEXR sees them. OpenEXR takes a mutable pointer even to write.
Imf::FrameBuffer make_frame_buffer(const Image& image) {
    const auto pixels = static_cast<std::size_t>(image.crop_width) * image.crop_height;
    Imf::FrameBuffer buffer;
    for (const Channel& channel : image.channels) {
        TALLOW_CHECK(channel.values.size() == pixels, "channel '{}' has {} values, {} pixels",
                     channel.name, channel.values.size(), pixels);
        buffer.insert(channel.name,
                      Imf::Slice::Make(Imf::FLOAT, channel.values.data(), data_window(image),
                                       sizeof(float), sizeof(float) * image.crop_width));
    }
    return buffer;
}

/// OpenEXR's own check of headers, so that it holds before it allocates line and tile buffers.
void set_limits_once() {
    static std::once_flag once;
    std::call_once(once, [] {
        Imf::Header::setMaxImageSize(kMaxSide, kMaxSide);
        Imf::Header::setMaxTileSize(kMaxTileSide, kMaxTileSide);
    });
}

void require_plain_image(const std::string& name, const Imf::MultiPartInputFile& file) {
    if (file.parts() != 1)
        throw InputError(fmt::format("{}: expected one part, got {}", name, file.parts()));
    const Imf::Header& header = file.header(0);
    if (header.hasType() && Imf::isDeepData(header.type()))
        throw InputError(fmt::format("{}: expected a flat image, got deep data", name));
    std::uint64_t channels = 0;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c, ++channels)
        if (c.channel().xSampling != 1 || c.channel().ySampling != 1)
            throw InputError(
                fmt::format("{}: channel '{}': expected one value a pixel, got a subsampled one",
                            name, c.name()));
    const Imath::Box2i& window = header.dataWindow();
    const std::uint64_t pixels = (std::int64_t{window.max.x} - window.min.x + 1) *
                                 (std::int64_t{window.max.y} - window.min.y + 1);
    if (channels == 0) throw InputError(fmt::format("{}: holds no channel", name));
    const std::uint64_t most =
        std::min(kMaxValues, kMaxValuesPerByte * std::filesystem::file_size(name));
    if (pixels > most / channels)
        throw InputError(
            fmt::format("{}: claims {} pixels of {} channels, more than the {} values "
                        "that a file of this size can hold",
                        name, pixels, channels, most));
}

Image make_image_like(const Imf::Header& header) {
    const Imath::Box2i &display = header.displayWindow(), &data = header.dataWindow();
    Image image;
    image.width = display.max.x - display.min.x + 1;
    image.height = display.max.y - display.min.y + 1;
    image.x0 = data.min.x - display.min.x;
    image.y0 = data.min.y - display.min.y;
    image.crop_width = data.max.x - data.min.x + 1;
    image.crop_height = data.max.y - data.min.y + 1;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
        image.add_channel(c.name());
    for (auto a = header.begin(); a != header.end(); ++a)
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute()))
            // "type" tells how the file is laid out, not what the picture is.
            if (std::string(a.name()) != "type")
                image.metadata.emplace_back(a.name(), text->value());
    return image;
}

Image read_part(const std::string& name) {
    Imf::MultiPartInputFile file(name.c_str(), 0);
    require_plain_image(name, file);
    const Imf::Header& header = file.header(0);
    Image image = make_image_like(header);

    const Imath::Box2i& window = header.dataWindow();
    Imf::FrameBuffer buffer;
    for (Channel& channel : image.channels)
        buffer.insert(channel.name,
                      Imf::Slice::Make(Imf::FLOAT, channel.values.data(), window, sizeof(float),
                                       sizeof(float) * image.crop_width));
    Imf::InputPart part(file, 0);
    part.setFrameBuffer(buffer);
    part.readPixels(window.min.y, window.max.y);
    return image;
}

}  // namespace

void write_exr(const std::filesystem::path& file, const Image& image) {
    Imf::StdOSStream stream;
    try {
        Imf::OutputFile exr(stream, make_header(image), 0);
        exr.setFrameBuffer(make_frame_buffer(image));
        exr.writePixels(image.crop_height);
    } catch (const Iex::BaseExc& e) {
        throw OutputError(fmt::format("{}: cannot encode the image: {}", file.string(), e.what()));
    }
    OutputFile output(file);
    output.write(stream.str());
    output.commit();
}

Image read_exr(const std::filesystem::path& file) {
    set_limits_once();
    try {
        return read_part(file.string());
    } catch (const Iex::BaseExc& e) {
        throw InputError(
            fmt::format("{}: not a readable OpenEXR image: {}", file.string(), e.what()));
    } catch (const std::filesystem::filesystem_error& e) {
        throw InputError(fmt::format("{}: {}", file.string(), e.code().message()));
    } catch (const std::bad_alloc&) {
        throw InputError(fmt::format("{}: does not fit into memory", file.string()));
    }
}

}  // namespace tallow
