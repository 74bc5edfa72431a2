// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "common/base/errors.h"
#include "common/base/output_file.h"
#include "common/base/parse_whole.h"
#include "common/base/tool_main.h"
#include "common/cloud/cache_info.h"
#include "common/cloud/cache_io.h"
#include "common/scene/scene_yaml.h"
#include "precompute/precompute.h"

using namespace tallow;

namespace {

struct Arguments {
    std::filesystem::path scene;
    std::optional<std::filesystem::path> output, info, export_ply;
    std::string spacing, light_samples;
    std::optional<double> points, tolerance, checkpoint_seconds;
    std::optional<int> bounces, indirect_samples;
    bool resume = false, plan = false, everything = false;
    std::vector<std::string> overrides;
};

void declare(CommandLine& line, Arguments& a) {
    line.positional("SCENE", a.scene, "Scene file (YAML or JSON)", false);
    line.path("-o,--output", a.output, "Cache file to write, usually NAME.tallow");
    line.text("--spacing", a.spacing,
              "Distance of neighbouring samples in mm, or auto: 0.35 mean free paths at a "
              "tolerance of 1 % [default: auto]",
              "MM|auto");
    line.number("--points", a.points, 1, 4e9, "a number of samples in [1, 4e9]",
                "Number of samples on all bodies together, met within 5 %, shared as --spacing "
                "auto would; in place of --spacing");
    line.number("--tolerance", a.tolerance, 0, std::nextafter(1.0, 0.0), "a number in [0, 1)",
                "Accepted relRMSE, used by --spacing auto [default: the scene's, or 0.01]");
    line.text(
        "--light-samples", a.light_samples,
        "Shadow rays for each sample and area light, or auto: as many as the tolerance needs, "
        "found by a pilot [default: the scene's, or auto]",
        "N|auto");
    line.integer("--bounces", a.bounces, 0, 64, "an integer in [0, 64]",
                 "Times that light may be reflected before it reaches a sample; 0 leaves indirect "
                 "light out [default: the scene's, or 2 where anything reflects]");
    line.integer("--indirect-samples", a.indirect_samples, 1, 65536, "an integer in [1, 65536]",
                 "Paths of indirect light from each sample [default: the scene's, or paths from "
                 "patches of samples, by the tolerance]");
    line.flag("--plan", a.plan, "Print what would be computed, what is left out and why, and stop");
    line.flag("--everything", a.everything, "Compute also what the plan would leave out");
    line.flag("--resume", a.resume,
              "Go on where an interrupted run stopped: what it had is in CACHE.part");
    line.number("--checkpoint-seconds", a.checkpoint_seconds, 0, 1e6, "a number >= 0",
                "How often CACHE.part is written [default: 5]");
    line.text_list("--set", a.overrides,
                   "Override a value of the scene, e.g. materials.wax.eta=1.4", "KEY=VALUE");
    line.path("--info", a.info, "Print what a cache file holds, and stop");
    line.path("--export-ply", a.export_ply,
              "Write the samples with their irradiance as PLY points, of the cache made or shown");
}

void show_info(const Arguments& a) {
    const MappedCache cache(*a.info);
    fmt::print("{}", describe_cache(cache));
    if (a.export_ply) export_ply(*a.export_ply, cache.view());
}

std::optional<int> parse_light_samples(const Arguments& a) {
    if (a.light_samples == "auto") return std::nullopt;
    const std::optional<int> count = parse_whole<int>(a.light_samples);
    if (!count || *count < 1 || *count > 65536)
        throw UsageError(
            fmt::format("--light-samples: expected an integer in [1, 65536], or auto, got '{}'",
                        a.light_samples));
    return count;
}

// Told before the work, not after it.
void require_outputs_writable(const Arguments& a) {
    require_writable(*a.output);
    if (a.export_ply) require_writable(*a.export_ply);
}

void make_cache(const Arguments& a, ToolRun& run) {
    if (a.scene.empty()) throw UsageError("SCENE: expected a scene file");
    if (!a.output && !a.plan) throw UsageError("--output: expected a cache file to write");
    if (!a.plan) require_outputs_writable(a);
    PrecomputeOptions options;
    options.sampling.samples = a.points;
    if (a.points && !a.spacing.empty())
        throw UsageError("--points: expected without --spacing, got both");
    if (!a.spacing.empty() && a.spacing != "auto")
        options.sampling.spacing =
            float(parse_number("--spacing", a.spacing, 1e-6, 1e6, "a number of mm > 0, or auto"));
    PhaseTimer load_timer(run.stats, "load");
    Scene scene = load_scene(a.scene, a.overrides);
    load_timer.stop();
    if (a.tolerance) scene.settings.tolerance = float(*a.tolerance);
    if (a.bounces) scene.settings.bounces = *a.bounces;
    if (a.indirect_samples) scene.settings.indirect_samples = *a.indirect_samples;
    options.checkpoint.resume = a.resume;
    if (a.checkpoint_seconds) options.checkpoint.seconds = *a.checkpoint_seconds;
    if (!a.light_samples.empty()) scene.settings.light_samples = parse_light_samples(a);

    if (a.everything) scene.settings.everything = true;
    options.plan_only = a.plan;
    precompute(scene, options, a.output.value_or(""), run.progress, run.stats);
    if (a.plan) {
        fmt::print("{}", plan_text(run.stats.plan));
        return;
    }
    if (a.export_ply) export_ply(*a.export_ply, MappedCache(*a.output).view());
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    return tool_main(
        "tallow-precompute",
        "Pass one: samples the translucent surfaces of a scene, gathers the light that enters at "
        "each sample and writes a cache file that serves every camera.",
        argc, argv, [&](CommandLine& line) { declare(line, arguments); },
        [&](ToolRun& run) {
            if (arguments.info)
                show_info(arguments);
            else
                make_cache(arguments, run);
        });
}
