// SPDX-License-Identifier: Apache-2.0
// Pixels -> named channels of an image.
#include "render/film.h"

#include <algorithm>
#include <array>
#include <functional>

#include "common/base/check.h"

namespace tallow {
namespace {

using Value = std::function<float(const Pixel&)>;

struct LayerChannel {
    std::string name;
    Value value;
};

// "layer.R", "layer.G", "layer.B" of a colour.
std::vector<LayerChannel> colour(const std::string& layer, Rgb Pixel::*member) {
    std::vector<LayerChannel> channels;
    for (int c = 0; c < 3; ++c)
        channels.push_back(
            {layer + "." + "RGB"[c], [=](const Pixel& p) { return (p.*member)[c]; }});
    return channels;
}

// Position and normal: means over the rays that met a surface, not over the pixel.
std::vector<LayerChannel> vector(const std::string& layer, Vec3 Pixel::*member) {
    std::vector<LayerChannel> channels;
    for (int axis = 0; axis < 3; ++axis)
        channels.push_back({layer + "." + "XYZ"[axis], [=](const Pixel& p) {
                                return p.coverage > 0 ? (p.*member)[axis] / p.coverage : 0.0f;
                            }});
    return channels;
}

const std::array<std::string, 14> kLayers = {
    "multiple", "single",      "diffuse", "specular", "transmitted", "emission", "scattered",
    "exitance", "error_bound", "albedo",  "N",        "P",           "Z",        "evaluations"};

std::vector<LayerChannel> layer_channels(const std::string& layer) {
    if (layer == "multiple") return colour(layer, &Pixel::multiple);
    if (layer == "single") return colour(layer, &Pixel::single);
    if (layer == "diffuse") return colour(layer, &Pixel::diffuse);
    if (layer == "specular") return colour(layer, &Pixel::specular);
    if (layer == "transmitted") return colour(layer, &Pixel::transmitted);
    if (layer == "emission") return colour(layer, &Pixel::emission);
    if (layer == "scattered") return colour(layer, &Pixel::scattered);
    if (layer == "exitance") return colour(layer, &Pixel::exitance);
    if (layer == "error_bound") return colour(layer, &Pixel::error_bound);
    if (layer == "albedo") return colour(layer, &Pixel::albedo);
    if (layer == "N") return vector(layer, &Pixel::normal);
    if (layer == "P") return vector(layer, &Pixel::position);
    if (layer == "Z")
        return {{"Z", [](const Pixel& p) { return p.coverage > 0 ? p.depth / p.coverage : 0.0f; }}};
    TALLOW_CHECK(layer == "evaluations", "layer '{}'", layer);
    return {{"evaluations", [](const Pixel& p) { return p.evaluations; }}};
}

}  // namespace

std::span<const std::string> layer_names() { return kLayers; }

Image develop(const Camera& camera, const Tile& crop, std::span<const Pixel> pixels,
              std::span<const std::string> layers) {
    Image image = make_image(camera.width, camera.height);
    image.x0 = crop.x0, image.y0 = crop.y0;
    image.crop_width = crop.width(), image.crop_height = crop.y1 - crop.y0;

    std::vector<LayerChannel> channels;
    for (int c = 0; c < 3; ++c)
        channels.push_back(
            {std::string(1, "RGB"[c]), [c](const Pixel& p) { return p.radiance()[c]; }});
    channels.push_back({"A", [](const Pixel& p) { return p.coverage; }});
    for (const std::string& layer : layers)
        for (LayerChannel& channel : layer_channels(layer)) channels.push_back(std::move(channel));

    for (const auto& [name, value] : channels) {
        std::vector<float>& values = image.add_channel(name);
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            values[i] = value(pixels[i]);
            TALLOW_CHECK(std::isfinite(values[i]), "channel {} of pixel ({}, {}) is {}", name,
                         crop.x0 + int(i) % crop.width(), crop.y0 + int(i) / crop.width(),
                         values[i]);
        }
    }
    return image;
}

}  // namespace tallow
