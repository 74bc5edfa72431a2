// SPDX-License-Identifier: Apache-2.0
// Frame -> files.
#include "viewer/screenshot.h"

#include <fmt/format.h>

#include "common/base/output_file.h"
#include "common/image/exr_io.h"
#include "common/image/png_io.h"
#include "render/film.h"
#include "render/render_image.h"
#include "viewer/camera_text.h"
#include "viewer/picture.h"

namespace tallow {
namespace {

std::filesystem::path with_extension(const std::filesystem::path& stem, const char* extension) {
    return stem.string() + extension;
}

/// folder/NAME_0001, or the first that no file has.
std::filesystem::path free_name(const std::filesystem::path& folder, const std::string& name) {
    for (int number = 1;; ++number) {
        const std::filesystem::path stem = folder / fmt::format("{}_{:04}", name, number);
        bool is_free = true;
        for (const char* extension : {".png", ".exr", ".yaml"})
            is_free &= !std::filesystem::exists(with_extension(stem, extension));
        if (is_free) return stem;
    }
}

}  // namespace

Image frame_image(const ViewFrame& frame) {
    const Tile whole = whole_image(frame.camera);
    std::vector<Pixel> pixels(whole.pixels());
    for (const TilePixels& tile : frame.tiles) place(tile.tile, tile.pixels, whole, pixels);
    std::vector<std::string> layers(layer_names().begin(), layer_names().end());
    if (!frame.certified) std::erase(layers, "error_bound");
    Image image = develop(frame.camera, whole, pixels, layers);
    image.metadata = {
        {frame.certified ? "tallow/certified" : "tallow/tolerance",
         fmt::format("{}", frame.tolerance)},
        {"tallow/samples", fmt::format("{}", frame.samples)},
        {"tallow/quality", frame.draft ? "draft" : "full"},
    };
    return image;
}

void write_frame(const std::filesystem::path& file, const ViewFrame& frame, const ViewState& state,
                 const decltype(Image::metadata)& metadata) {
    if (file.extension() == ".exr") {
        Image image = frame_image(frame);
        image.metadata.insert(image.metadata.begin(), metadata.begin(), metadata.end());
        write_exr(file, image);
        return;
    }
    const Picture picture = make_picture(frame, state.aov(), state.exposure());
    write_png(file, picture.width, picture.height, picture.rgb);
}

std::filesystem::path save_screenshot(const std::filesystem::path& folder, const Scene& scene,
                                      const ViewFrame& frame, const ViewState& state,
                                      const decltype(Image::metadata)& metadata) {
    const std::filesystem::path stem = free_name(folder, scene.file.stem().string());
    write_frame(with_extension(stem, ".png"), frame, state, metadata);
    write_frame(with_extension(stem, ".exr"), frame, state, metadata);
    // A name that a scene allows, whatever the file is called.
    const std::string number = stem.string().substr(stem.string().rfind('_') + 1);
    OutputFile camera(with_extension(stem, ".yaml"));
    camera.write(camera_text(scene, frame.camera, "view_" + number));
    camera.commit();
    return stem;
}

}  // namespace tallow
