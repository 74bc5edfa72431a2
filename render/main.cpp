// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/parse_whole.h"
#include "common/base/tool_main.h"
#include "common/cloud/cache_io.h"
#include "common/cloud/scene_fingerprint.h"
#include "common/exitance/scene_plan.h"
#include "common/image/exr_io.h"
#include "common/image/png_io.h"
#include "common/scene/scene_yaml.h"
#include "render/film.h"
#include "render/render_image.h"

using namespace tallow;

namespace {

// Below, rounding in float and the error of the kernel's table leave no room.
constexpr double kSmallestCertificate = 1e-4;

struct Arguments {
    std::filesystem::path scene;
    std::optional<std::filesystem::path> cache;
    std::vector<std::string> outputs, overrides;
    std::string camera, crop, aovs = "none", criterion = "error";
    std::optional<double> tolerance, certify, exposure;
    std::optional<int> samples;
    bool plan = false, everything = false;
};

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
    line.text("--crop", a.crop, "Render these pixels only; X1 and Y1 are not included",
              "X0,Y0,X1,Y1");
    line.text("--aovs", a.aovs,
              fmt::format("Layers to add to an EXR, separated by commas: all, none or some of {} "
                          "[default: none]",
                          fmt::join(layer_names(), ", ")),
              "LIST");
    line.number("--exposure", a.exposure, -64, 64, "a number in [-64, 64]",
                "Brightness of a PNG in stops [default: 0]");
    line.flag("--plan", a.plan, "Print what would be computed, what is left out and why, and stop");
    line.flag("--everything", a.everything, "Compute also what the plan would leave out");
    line.text_list("--set", a.overrides, "Override a value of the scene, e.g. groups.key.scale=2",
                   "KEY=VALUE");
}

std::vector<std::string> split(const std::string& list) {
    std::vector<std::string> items(1);
    for (char c : list)
        if (c == ',')
            items.emplace_back();
        else
            items.back() += c;
    return items;
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

// All layers leave out the one that only a certificate can fill.
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
    if (text.empty()) return {0, 0, camera.width, camera.height};
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

int find_camera(const Scene& scene, const std::string& name) {
    if (name.empty()) return 0;
    std::vector<std::string> names;
    for (const Camera& camera : scene.cameras) {
        if (camera.name == name) return int(names.size());
        names.push_back(camera.name);
    }
    throw UsageError(
        fmt::format("--camera: expected one of {}, got '{}'", fmt::join(names, ", "), name));
}

void require_image_names(const std::vector<std::string>& outputs) {
    if (outputs.empty()) throw UsageError("--output: expected an image to write");
    for (const std::filesystem::path name : outputs)
        if (name.extension() != ".exr" && name.extension() != ".png")
            throw UsageError(
                fmt::format("--output: expected a name ending in .exr or .png, got "
                            "'{}'",
                            name.string()));
}

/// The cache, checked against the scene; an empty one if nothing in the scene needs it.
std::optional<MappedCache> open_cache(const Arguments& a, const ScenePlan& planned,
                                      const SceneGeometry& geometry) {
    const Scene& scene = planned.scene;
    std::vector<std::uint32_t> needed;  // objects whose samples the picture needs
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (subsurface(scene, i) != nullptr && planned.treatment[i] == Treatment::samples)
            needed.push_back(i);
    if (!a.cache) {
        if (!needed.empty())
            throw UsageError(
                "--cache: expected a cache file, because the scene has translucent "
                "bodies; make one with tallow-precompute");
        return std::nullopt;
    }
    MappedCache cache(*a.cache);
    require_fingerprint(*a.cache, cache.view().fingerprint, scene_fingerprint(scene, geometry));
    for (const std::uint32_t object : needed)
        if (std::ranges::find(cache.view().bodies, object, &BodyView::object) ==
            cache.view().bodies.end())
            throw InputError(
                fmt::format("{}: has no samples of objects[{}]: the cameras and the tolerance that "
                            "it was made for "
                            "did not need them; re-run tallow-precompute with these",
                            a.cache->string(), object));
    return cache;
}

void add_lights(Plan& plan, const Scene& scene) {
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        if (max_channel(scene.groups[scene.lights[i].group].scale) == 0)
            plan.decisions.push_back({fmt::format("lights[{}]", i), "shadow rays", false,
                                      "not followed", "its group's scale is 0", 0.0});
}

// The dipoles and normalized diffusion hold part of the first order, which single scattering adds.
void note_double_counting(const Scene& scene, Progress& progress) {
    for (const Material& material : scene.materials) {
        const auto* body = std::get_if<SubsurfaceMaterial>(&material.kind);
        if (body == nullptr || body->single_scattering == Switch::off) continue;
        if (body->model == Model::transport || body->model == Model::photon_beam_diffusion ||
            body->model == Model::body_aware)
            continue;
        progress.note(fmt::format(
            "materials.{}: this model and single scattering both hold the first scattering order: "
            "up "
            "to 8 % too bright at eta 1.3; use model: transport, or single_scattering: off",
            material.name));
    }
}

void add_metadata(Image& image, const Arguments& a, const Scene& scene, const Camera& camera,
                  const CacheView& cache, const RenderOptions& options, const Stats& stats) {
    image.metadata = {
        {"tallow/scene", a.scene.string()},
        {"tallow/camera", camera.name},
        {"tallow/cache", cache.fingerprint.empty() ? "none" : fingerprint_id(cache.fingerprint)},
        {options.accuracy.certified ? "tallow/certified" : "tallow/tolerance",
         fmt::format("{}", options.accuracy.tolerance)},
        {"tallow/criterion", a.criterion},
        {"tallow/samples", fmt::format("{}", scene.settings.samples)},
        {"tallow/version", stats.versions.at("tallow")},
    };
}

void render(const Arguments& a, ToolRun& run) {
    if (!a.plan) require_image_names(a.outputs);
    RenderOptions options;
    options.accuracy = parse_accuracy(a);
    options.layers = parse_layers(a.aovs, a.certify.has_value());

    PhaseTimer load_timer(run.stats, "load");
    Scene loaded = load_scene(a.scene, a.overrides);
    if (!a.certify && !a.tolerance) options.accuracy.tolerance = loaded.settings.tolerance;
    if (a.samples) loaded.settings.samples = *a.samples;
    if (a.everything) loaded.settings.everything = true;
    options.camera = find_camera(loaded, a.camera);
    const Camera camera = loaded.cameras[std::size_t(options.camera)];
    options.crop = parse_crop(a.crop, camera);
    load_timer.stop();
    const SceneGeometry geometry = load_geometry(loaded, run.stats);

    PhaseTimer plan_timer(run.stats, "plan");
    ScenePlan planned = plan_scene(loaded, geometry, double(options.accuracy.tolerance));
    add_lights(planned.plan, loaded);
    options.diffuse = planned.diffuse;
    run.stats.plan = planned.plan;
    plan_timer.stop();
    if (a.plan) {
        fmt::print("{}", plan_text(planned.plan));
        return;
    }
    const Scene& scene = planned.scene;
    note_double_counting(scene, run.progress);

    PhaseTimer map_timer(run.stats, "map");
    const std::optional<MappedCache> cache = open_cache(a, planned, geometry);
    map_timer.stop();
    const CacheView view = cache ? cache->view() : CacheView{};

    Image image = render_image(scene, geometry, view, options, run.progress, run.stats);

    PhaseTimer write_timer(run.stats, "write");
    add_metadata(image, a, scene, camera, view, options, run.stats);
    for (const std::filesystem::path output : a.outputs) {
        if (output.extension() == ".exr")
            write_exr(output, image);
        else
            write_png(output, image, float(a.exposure.value_or(0)));
        run.progress.note(fmt::format("wrote {}", output.string()));
    }
    write_timer.stop();
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    return tool_main(
        "tallow-render",
        "Pass two: renders a camera's image from a scene and the cache that tallow-precompute made "
        "of it.",
        argc, argv, [&](CommandLine& line) { declare(line, arguments); },
        [&](ToolRun& run) { render(arguments, run); });
}
