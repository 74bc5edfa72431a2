// SPDX-License-Identifier: Apache-2.0
// Flags -> what they mean.
#include "render/arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/parse_whole.h"
#include "render/film.h"
#include "render/render_image.h"

namespace tallow {
namespace {

// Below, rounding in float and the error of the kernel's table leave no room.
constexpr double kSmallestCertificate = 1e-4;

std::vector<std::string> split(const std::string& list) {
    std::vector<std::string> items(1);
    for (char c : list)
        if (c == ',')
            items.emplace_back();
        else
            items.back() += c;
    return items;
}

}  // namespace

void declare(CommandLine& line, Arguments& a) {
    line.positional("SCENE", a.scene, "Scene file (YAML or JSON)");
    line.path("--cache", a.cache,
              "Cache file made by tallow-precompute; needed if the scene has translucent bodies");
    line.text_list(
        "-o,--output", a.outputs,
        "Image to write: .exr holds linear radiance and layers, .png is tone-mapped; may "
        "be given twice",
        "IMAGE.exr|.png");
    line.number("--tolerance", a.tolerance, 0, std::nextafter(1.0, 0.0), "a number in [0, 1)",
                "Accepted relRMSE of the hierarchical sum; 0 is the plain sum over all samples "
                "[default: the scene's, or 0.01]");
    line.number(
        "--certify", a.certify, kSmallestCertificate, std::nextafter(1.0, 0.0),
        "a number in [1e-4, 1)",
        "Instead of --tolerance: the error of the hierarchical sum is to be below this part "
        "of the plain sum in each pixel and channel, with proof (layer error_bound)");
    line.text("--criterion", a.criterion,
              "How the hierarchy is cut: error, by bounds of the error; solid-angle, by the "
              "classical method, one pixel at a time, for comparison [default: error]",
              "error|solid-angle");
    line.integer("--samples", a.samples, 1, 65536, "an integer in [1, 65536]",
                 "Camera rays a pixel [default: the scene's, or 16]");
    line.text("--camera", a.camera, "Camera to use [default: the scene's first]", "NAME");
    line.text("--frames", a.frames,
              "Render these frames of a camera that moves, the last included; --output then names "
              "many files: #### becomes the frame's number with as many digits, as in "
              "turn_####.exr [default: frame 0]",
              "A-B|A");
    line.text("--crop", a.crop, "Render these pixels only; X1 and Y1 are not included",
              "X0,Y0,X1,Y1");
    line.text("--aovs", a.aovs,
              fmt::format("Layers to add to an EXR, separated by commas: all, none or some of {} "
                          "[default: none]",
                          fmt::join(layer_names(), ", ")),
              "LIST");
    line.number("--exposure", a.exposure, -64, 64, "a number in [-64, 64]",
                "Brightness of a PNG in stops [default: 0]");
    line.optional_text("--preview", a.preview,
                       "Show tiles as they are finished in a tev that is running [default: "
                       "127.0.0.1:14158]",
                       "HOST:PORT");
    line.flag("--plan", a.plan, "Print what would be computed, what is left out and why, and stop");
    line.flag("--everything", a.everything, "Compute also what the plan would leave out");
    line.text_list("--set", a.overrides, "Override a value of the scene, e.g. groups.key.scale=2",
                   "KEY=VALUE");
}

ExitanceAccuracy parse_accuracy(const Arguments& a) {
    using Criterion = ExitanceAccuracy::Criterion;
    if (a.criterion != "error" && a.criterion != "solid-angle")
        throw UsageError(
            fmt::format("--criterion: expected error or solid-angle, got '{}'", a.criterion));
    const auto criterion = a.criterion == "error" ? Criterion::error : Criterion::solid_angle;
    if (a.certify && a.tolerance)
        throw UsageError("--certify: expected instead of --tolerance, got both");
    if (a.certify && criterion == Criterion::solid_angle)
        throw UsageError(
            "--certify: expected --criterion error, got solid-angle, which has no bound");
    return {float(a.certify.value_or(a.tolerance.value_or(0))), criterion, a.certify.has_value()};
}

std::vector<std::string> parse_layers(const std::string& list, bool certified) {
    const auto known = layer_names();
    if (list == "none") return {};
    if (list == "all") {
        std::vector<std::string> all(known.begin(), known.end());
        if (!certified) std::erase(all, "error_bound");
        return all;
    }
    const std::vector<std::string> layers = split(list);
    for (std::size_t i = 0; i < layers.size(); ++i) {
        if (std::find(known.begin(), known.end(), layers[i]) == known.end())
            throw UsageError(fmt::format("--aovs: expected all, none or some of {}, got '{}'",
                                         fmt::join(known, ", "), layers[i]));
        if (std::find(layers.begin(), layers.begin() + std::ptrdiff_t(i), layers[i]) !=
            layers.begin() + std::ptrdiff_t(i))
            throw UsageError(fmt::format("--aovs: '{}' is asked for twice", layers[i]));
        if (layers[i] == "error_bound" && !certified)
            throw UsageError("--aovs: error_bound needs --certify");
    }
    return layers;
}

Tile parse_crop(const std::string& text, const Camera& camera) {
    if (text.empty()) return whole_image(camera);
    const auto fail = [&] {
        return UsageError(fmt::format(
            "--crop: expected four integers X0,Y0,X1,Y1 inside {} x {} pixels, got '{}'",
            camera.width, camera.height, text));
    };
    const std::vector<std::string> items = split(text);
    if (items.size() != 4) throw fail();
    int v[4];
    for (std::size_t i = 0; i < 4; ++i) {
        const std::optional<int> value = parse_whole<int>(items[i]);
        if (!value || *value < 0 || *value > (i % 2 == 0 ? camera.width : camera.height))
            throw fail();
        v[i] = *value;
    }
    if (v[0] >= v[2] || v[1] >= v[3]) throw fail();
    return {v[0], v[1], v[2], v[3]};
}

std::optional<FrameRange> frames_of(const Arguments& a) {
    return a.frames.empty() ? std::nullopt : std::optional(parse_frames(a.frames));
}

void require_image_names(const Arguments& a) {
    const auto frames = frames_of(a);
    if (a.outputs.empty()) throw UsageError("--output: expected an image to write");
    for (const std::filesystem::path name : a.outputs) {
        if (name.extension() != ".exr" && name.extension() != ".png")
            throw UsageError(fmt::format(
                "--output: expected a name ending in .exr or .png, got '{}'", name.string()));
        if (frames && frames->has_many() && !has_frame_field(name))
            throw UsageError(
                fmt::format("--output: expected a name with #### for the number of the frame, as "
                            "in turn_####.exr, got '{}'",
                            name.string()));
    }
}

}  // namespace tallow
