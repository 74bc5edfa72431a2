// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>

#include "common/base/errors.h"
#include "common/base/output_file.h"
#include "common/base/tool_main.h"
#include "common/cloud/cache_io.h"
#include "common/exitance/scene_plan.h"
#include "common/image/exr_io.h"
#include "common/image/png_io.h"
#include "common/scene/scene_yaml.h"
#include "render/arguments.h"
#include "render/check_cache.h"
#include "render/find_camera.h"
#include "render/render_image.h"
#include "render/tev_preview.h"

using namespace tallow;

namespace {

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

/// The camera as it stands in each frame that is asked for.
std::vector<Camera> list_views(const Arguments& a, const Camera& camera) {
    const auto frames = frames_of(a);
    if (frames) require_frames(camera, *frames);
    std::vector<Camera> views;
    for (int frame = frames ? frames->first : 0; frame <= (frames ? frames->last : 0); ++frame)
        views.push_back(camera_at(camera, frame));
    return views;
}

/// Everything that pictures are made from.
struct Input {
    ScenePlan planned;
    SceneGeometry geometry;
    ExitanceAccuracy accuracy;
    bool moves;                 // the camera
    std::vector<Camera> views;  // one a frame
    RenderOptions options;
};

Input read_input(const Arguments& a, Stats& stats) {
    Input input;
    input.accuracy = parse_accuracy(a);
    input.options.layers = parse_layers(a.aovs, a.certify.has_value());

    PhaseTimer load_timer(stats, "load");
    Scene scene = load_scene(a.scene, a.overrides);
    if (!a.certify && !a.tolerance) input.accuracy.tolerance = scene.settings.tolerance;
    if (a.samples) scene.settings.samples = *a.samples;
    if (a.everything) scene.settings.everything = true;
    input.options.samples = scene.settings.samples;
    const Camera& camera = find_camera(scene, a.camera);
    input.moves = frame_count(camera) > 1;
    input.views = list_views(a, camera);
    input.options.crop = parse_crop(a.crop, camera);
    load_timer.stop();
    input.geometry = load_geometry(scene, stats);

    const PhaseTimer plan_timer(stats, "plan");
    input.planned = plan_scene(scene, input.geometry, double(input.accuracy.tolerance));
    add_lights(input.planned.plan, scene);
    stats.plan = input.planned.plan;
    return input;
}

/// The cache, checked against the scene; an empty one if nothing in the scene needs it.
std::optional<MappedCache> open_cache(const Arguments& a, const Input& input) {
    if (!a.cache) {
        if (!bodies_to_sample(input.planned).empty())
            throw UsageError(
                "--cache: expected a cache file, because the scene has translucent "
                "bodies; make one with tallow-precompute");
        return std::nullopt;
    }
    MappedCache cache(*a.cache);
    require_cache_of(input.planned, input.geometry, *a.cache, cache.view());
    return cache;
}

decltype(Image::metadata) describe(const Arguments& a, const Input& input, const Camera& view,
                                   const CacheView& cache, const Stats& stats) {
    decltype(Image::metadata) metadata = {
        {"tallow/scene", a.scene.string()},
        {"tallow/camera", view.name},
        {"tallow/cache", cache.fingerprint.empty() ? "none" : fingerprint_id(cache.fingerprint)},
        {input.accuracy.certified ? "tallow/certified" : "tallow/tolerance",
         fmt::format("{}", input.accuracy.tolerance)},
        {"tallow/criterion", a.criterion},
        {"tallow/samples", fmt::format("{}", input.options.samples)},
        {"tallow/version", stats.versions.at("tallow")},
    };
    if (input.moves) metadata.emplace_back("tallow/frame", fmt::format("{}", view.frame));
    return metadata;
}

std::filesystem::path output_of_frame(const Arguments& a, const std::string& name, int frame) {
    return a.frames.empty() ? std::filesystem::path(name) : frame_file(name, frame);
}

// Told before the work, not after it.
void require_outputs_writable(const Arguments& a, std::span<const Camera> views) {
    for (const Camera& view : views)
        for (const std::string& name : a.outputs)
            require_writable(output_of_frame(a, name, view.frame));
}

void write(const Arguments& a, const Image& image, int frame, ToolRun& run) {
    const PhaseTimer timer(run.stats, "write");
    for (const std::string& name : a.outputs) {
        const auto output = output_of_frame(a, name, frame);
        if (output.extension() == ".exr")
            write_exr(output, image);
        else
            write_png(output, image, float(a.exposure.value_or(0)));
        run.progress.note(fmt::format("wrote {}", output.string()));
    }
}

/// Shows a frame's tiles in a tev, if one is there, under the name of the first output.
class FramePreview {
public:
    FramePreview(const Arguments& a, Progress& progress) : a_(a), progress_(progress) {
        if (a.preview) tev_.emplace(parse_tev_address(*a.preview));
        warn();
    }

    /// `options` are then told to send tiles. It must outlive the rendering.
    void begin(const Camera& view, RenderOptions& options) {
        if (!tev_) return;
        const std::string name = output_of_frame(a_, a_.outputs.front(), view.frame).string();
        tev_->create(name, develop(view, {0, 0, 0, 0}, {}, options.layers));
        options.on_tile = [this, name, &view, &options](const Tile& tile,
                                                        std::span<const Pixel> pixels) {
            tev_->update(name, develop(view, tile, pixels, options.layers));
            warn();
        };
        warn();
    }

private:
    // Once: the picture is rendered all the same.
    void warn() {
        if (!tev_ || tev_->problem().empty() || warned_) return;
        progress_.note("tallow-render: warning: " + tev_->problem());
        warned_ = true;
    }

    const Arguments& a_;
    Progress& progress_;
    std::optional<TevPreview> tev_;
    bool warned_ = false;
};

void render(const Arguments& a, ToolRun& run) {
    if (!a.plan) require_image_names(a);
    if (a.preview) parse_tev_address(*a.preview);  // refused before any work
    Input input = read_input(a, run.stats);
    if (a.plan) {
        fmt::print("{}", plan_text(input.planned.plan));
        return;
    }
    require_outputs_writable(a, input.views);
    note_double_counting(input.planned.scene, run.progress);
    PhaseTimer map_timer(run.stats, "map");
    const std::optional<MappedCache> cache = open_cache(a, input);
    map_timer.stop();
    const CacheView cached = cache ? cache->view() : CacheView{};
    const PreparedScene world(input.planned.scene, input.geometry, cached, input.accuracy,
                              input.planned.diffuse, run.stats);

    for (const std::string& warning : world.warnings()) run.progress.note(warning);
    // Before the first frame takes its time.
    for (const Camera& view : input.views)
        require_camera_outside(world.scene(), world.rays(), view);
    FramePreview preview(a, run.progress);
    for (const Camera& view : input.views) {
        preview.begin(view, input.options);
        const auto start = std::chrono::steady_clock::now();
        Image image = render_image(world, view, input.options, run.progress, run.stats);
        image.metadata = describe(a, input, view, cached, run.stats);
        write(a, image, view.frame, run);
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
        if (!a.frames.empty()) run.stats.frames.push_back({view.frame, elapsed.count()});
    }
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    return tool_main(
        "tallow-render",
        "Pass two: renders a camera's image, or many frames of it, from a scene and the cache that "
        "tallow-precompute made of it.",
        argc, argv, [&](CommandLine& line) { declare(line, arguments); },
        [&](ToolRun& run) { render(arguments, run); });
}
