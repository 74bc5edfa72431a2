// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "common/base/errors.h"
#include "common/base/output_file.h"
#include "common/base/tool_main.h"
#include "common/image/exr_io.h"
#include "common/scene/scene_yaml.h"
#include "experiments/reference/render_reference.h"

using namespace tallow;

namespace {

struct Arguments {
    std::filesystem::path scene;
    std::optional<std::filesystem::path> output;
    std::vector<std::string> overrides;
    std::string camera, estimator = "combined";
    std::optional<double> noise, paths, seconds;
    std::optional<int> seed;
    bool resume = false;
};

void declare(CommandLine& line, Arguments& a) {
    line.positional("SCENE", a.scene, "Scene file (YAML or JSON)");
    line.path("-o,--output", a.output, "Image to write, an EXR");
    line.text_list("--set", a.overrides, "Override a value of the scene, e.g. groups.key.scale=2",
                   "KEY=VALUE");
    line.text("--camera", a.camera, "Camera to use [default: the scene's first]", "NAME");
    line.number("--noise", a.noise, 1e-6, 1e6, "a number in [1e-6, 1e6]",
                "Stop at this relative standard error of the pixels [default: 0.03, if nothing "
                "else stops it]");
    line.number("--paths", a.paths, 1, 1e15, "a number in [1, 1e15]",
                "Stop after so many walks from the lamps, rounded up to whole batches");
    line.number("--seconds", a.seconds, 0, 1e9, "a number in [0, 1e9]",
                "Stop after so much time, of all runs that --resume joined");
    line.integer("--seed", a.seed, 0, 1 << 30, "an integer in [0, 2^30]",
                 "Of the random numbers [default: 1]");
    line.text("--estimator", a.estimator,
              "combined: walks from the lamps linked to the camera, and walks from the camera for "
              "what links cannot reach; camera: walks from the camera only, slow, as a check",
              "combined|camera");
    line.flag("--resume", a.resume, "Go on from the checkpoint beside the image");
}

const Camera& find_camera(const Scene& scene, const std::string& name) {
    if (name.empty()) return scene.cameras.front();
    std::vector<std::string> names;
    for (const Camera& camera : scene.cameras) {
        if (camera.name == name) return camera;
        names.push_back(camera.name);
    }
    throw UsageError(
        fmt::format("--camera: expected one of {}, got '{}'", fmt::join(names, ", "), name));
}

reference::Options make_options(const Arguments& a) {
    if (!a.output || a.output->extension() != ".exr")
        throw UsageError(fmt::format("--output: expected a name ending in .exr, got '{}'",
                                     a.output ? a.output->string() : ""));
    if (a.estimator != "combined" && a.estimator != "camera")
        throw UsageError(
            fmt::format("--estimator: expected combined or camera, got '{}'", a.estimator));
    reference::Options options;
    options.noise = a.noise;
    options.paths = a.paths;
    options.seconds = a.seconds;
    if (!a.noise && !a.paths && !a.seconds) options.noise = 0.03;
    options.seed = std::uint64_t(a.seed.value_or(1));
    options.camera_only = a.estimator == "camera";
    options.checkpoint = a.output->string() + ".checkpoint";
    options.resume = a.resume;
    return options;
}

void render(const Arguments& a, ToolRun& run) {
    const reference::Options options = make_options(a);
    require_writable(*a.output);
    PhaseTimer load_timer(run.stats, "load");
    const Scene scene = load_scene(a.scene, a.overrides);
    const Camera camera = find_camera(scene, a.camera);
    load_timer.stop();
    const SceneGeometry geometry = load_geometry(scene, run.stats);
    Image image = reference::render_reference(scene, geometry, camera, options, run);
    image.metadata.insert(image.metadata.begin(),
                          {{"tallow/scene", a.scene.string()},
                           {"tallow/set", fmt::format("{}", fmt::join(a.overrides, " "))},
                           {"tallow/camera", camera.name},
                           {"tallow/version", run.stats.versions.at("tallow")}});
    write_exr(*a.output, image);
    run.progress.note(fmt::format("wrote {}", a.output->string()));
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    return tool_main(
        "tallow-reference",
        "Volumetric truth: an unbiased picture of translucent bodies, and its variance, to measure "
        "models against.",
        argc, argv, [&](CommandLine& line) { declare(line, arguments); },
        [&](ToolRun& run) { render(arguments, run); });
}
