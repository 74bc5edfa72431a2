// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "common/base/errors.h"
#include "common/base/tool_main.h"
#include "common/cloud/cache_io.h"
#include "common/cloud/scene_fingerprint.h"
#include "common/exitance/scene_plan.h"
#include "common/image/exr_io.h"
#include "common/image/png_io.h"
#include "common/scene/scene_yaml.h"
#include "render/arguments.h"
#include "render/render_image.h"

using namespace tallow;

namespace {

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
                  const CacheView& cache, const ExitanceAccuracy& accuracy, const Stats& stats) {
    image.metadata = {
        {"tallow/scene", a.scene.string()},
        {"tallow/camera", camera.name},
        {"tallow/cache", cache.fingerprint.empty() ? "none" : fingerprint_id(cache.fingerprint)},
        {accuracy.certified ? "tallow/certified" : "tallow/tolerance",
         fmt::format("{}", accuracy.tolerance)},
        {"tallow/criterion", a.criterion},
        {"tallow/samples", fmt::format("{}", scene.settings.samples)},
        {"tallow/version", stats.versions.at("tallow")},
    };
}

void render(const Arguments& a, ToolRun& run) {
    if (!a.plan) require_image_names(a.outputs);
    ExitanceAccuracy accuracy = parse_accuracy(a);
    RenderOptions options;
    options.layers = parse_layers(a.aovs, a.certify.has_value());

    PhaseTimer load_timer(run.stats, "load");
    Scene loaded = load_scene(a.scene, a.overrides);
    if (!a.certify && !a.tolerance) accuracy.tolerance = loaded.settings.tolerance;
    if (a.samples) loaded.settings.samples = *a.samples;
    if (a.everything) loaded.settings.everything = true;
    options.samples = loaded.settings.samples;
    const Camera camera = find_camera(loaded, a.camera);
    options.crop = parse_crop(a.crop, camera);
    load_timer.stop();
    const SceneGeometry geometry = load_geometry(loaded, run.stats);

    PhaseTimer plan_timer(run.stats, "plan");
    ScenePlan planned = plan_scene(loaded, geometry, double(accuracy.tolerance));
    add_lights(planned.plan, loaded);
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

    const PreparedScene world(scene, geometry, view, accuracy, planned.diffuse, run.stats);
    Image image = render_image(world, camera, options, run.progress, run.stats);

    PhaseTimer write_timer(run.stats, "write");
    add_metadata(image, a, scene, camera, view, accuracy, run.stats);
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
