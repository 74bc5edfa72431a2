// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "common/base/errors.h"
#include "common/base/output_file.h"
#include "common/base/tool_main.h"
#include "material/find_material.h"
#include "material/material_json.h"
#include "material/material_text.h"
#include "material/profile_plot.h"
#include "material/swatch.h"
#include "material/vary_medium.h"

using namespace tallow;

namespace {

constexpr float kSmallestExtinction = 1e-6f;  // 1/mm, as in scene files
constexpr int kDefaultSteps = 5;

struct Arguments {
    std::filesystem::path material;
    std::string profile, sigma_a, sigma_s_prime, vary;
    std::optional<double> eta, g;
    std::vector<std::string> plots;
    bool json = false;
    std::optional<int> steps;
};

void declare(CommandLine& line, Arguments& a) {
    line.positional("MATERIAL", a.material,
                    "A preset's name, or SCENE:NAME for a translucent material of a scene file",
                    false);
    line.text("--profile", a.profile,
              "Distances in mm at which profiles are printed "
              "[default: 0.1 to 20 mean free paths]",
              "R,...");
    line.text_list("--plot", a.plots,
                   "Write profiles as .svg, or a rendered swatch as .png or .exr", "FILE");
    line.flag("--json", a.json, "Print JSON instead of tables");
    line.text("--vary", a.vary,
              "Render a row of swatches, from A to B: sigma_a or sigma_s_prime (mean of the "
              "channels in 1/mm, ratios kept), dilution (all three in equal ratios), eta or g (in "
              "equal steps)",
              "KEY=A..B");
    line.integer("--steps", a.steps, 1, 64, "an integer in [1, 64]",
                 fmt::format("Swatches of --vary [default: {}]", kDefaultSteps));
    line.text("--sigma-a", a.sigma_a, "Absorption coefficient in 1/mm", "R,G,B");
    line.text("--sigma-s-prime", a.sigma_s_prime, "Reduced scattering coefficient in 1/mm",
              "R,G,B");
    line.number("--eta", a.eta, 1, 3, "a relative index in [1, 3]",
                "Index of refraction, inside / outside");
    line.number("--g", a.g, -0.9999, 0.9999, "a number in [-0.9999, 0.9999]",
                "Mean cosine of scattering");
}

std::vector<double> parse_list(const std::string& flag, const std::string& text,
                               const std::string& range) {
    std::vector<double> values;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        values.push_back(parse_number(flag, text.substr(begin, end - begin), 0, 1e12, range));
        begin = end + 1;
    }
    return values;
}

Rgb parse_coefficient(const std::string& flag, const std::string& text) {
    const std::string expected = "three numbers R,G,B >= 0";
    const auto values = parse_list(flag, text, expected);
    if (values.size() != 3)
        throw UsageError(fmt::format("{}: expected {}, got '{}'", flag, expected, text));
    return {float(values[0]), float(values[1]), float(values[2])};
}

/// The material that the arguments name, changed or given by flags.
FoundMaterial choose_material(const Arguments& a) {
    const bool complete = !a.sigma_a.empty() && !a.sigma_s_prime.empty() && a.eta;
    if (a.material.empty() && !complete)
        throw UsageError(
            "MATERIAL: expected a preset, SCENE:NAME, or --sigma-a, --sigma-s-prime and --eta");
    FoundMaterial found = a.material.empty() ? FoundMaterial{"material", "flags", {}, false}
                                             : find_material(a.material.string());
    Medium& medium = found.material.medium;
    if (!a.sigma_a.empty()) medium.sigma_a = parse_coefficient("--sigma-a", a.sigma_a);
    if (!a.sigma_s_prime.empty())
        medium.sigma_s_prime = parse_coefficient("--sigma-s-prime", a.sigma_s_prime);
    if (a.eta) medium.eta = float(*a.eta);
    if (a.g) medium.g = float(*a.g);
    if (min_channel(medium.sigma_t_prime()) < kSmallestExtinction)
        throw UsageError(
            fmt::format("--sigma-a: expected sigma_a + sigma_s_prime >= {:g} in each channel, got "
                        "{:g}",
                        kSmallestExtinction, min_channel(medium.sigma_t_prime())));
    return found;
}

bool is_picture(const std::filesystem::path& file) {
    return file.extension() == ".png" || file.extension() == ".exr";
}

void require_plots(const Arguments& a) {
    bool picture = false;
    for (const std::filesystem::path file : a.plots) {
        picture = picture || is_picture(file);
        if (!is_picture(file) && file.extension() != ".svg")
            throw UsageError(fmt::format(
                "--plot: expected a name ending in .svg, .png or .exr, got '{}'", file.string()));
    }
    if (!a.vary.empty() && !picture)
        throw UsageError("--vary: expected a picture to write, --plot FILE.png or FILE.exr");
    if (a.steps && a.vary.empty())
        throw UsageError("--steps: expected a parameter to vary, --vary KEY=A..B");
}

/// The columns of a swatch; `legend` says what they show.
std::vector<SubsurfaceMaterial> swatch_columns(const Arguments& a, const FoundMaterial& found,
                                               std::string& legend) {
    if (a.vary.empty()) return {found.material};
    const Variation variation = parse_variation(a.vary);
    if (variation.knob == Knob::dilution && !found.dilutable)
        throw UsageError(
            fmt::format("--vary: dilution: '{}' is not the preset of a liquid", found.name));
    std::vector<SubsurfaceMaterial> columns;
    for (const double value : variation_values(variation, a.steps.value_or(kDefaultSteps))) {
        SubsurfaceMaterial material = found.material;
        material.medium = vary_medium(material.medium, variation.knob, value);
        columns.push_back(material);
        legend += fmt::format("swatch {}: {} = {:.4g}\n", columns.size(), variation.key, value);
    }
    return columns;
}

void write_text(const std::filesystem::path& file, const std::string& text) {
    OutputFile output(file);
    output.write(text);
    output.commit();
}

void describe(const Arguments& a, ToolRun& run) {
    require_plots(a);
    for (const std::filesystem::path file : a.plots) require_writable(file);
    const FoundMaterial found = choose_material(a);
    const Medium& medium = found.material.medium;
    const std::string title = fmt::format("{} ({})", found.name, found.origin);
    const auto radii = a.profile.empty()
                           ? default_radii(medium)
                           : parse_list("--profile", a.profile, "distances R,... >= 0 in mm");
    std::string legend;
    const auto columns = swatch_columns(a, found, legend);

    const MaterialReport report = describe_material(medium, radii);
    fmt::print("{}", a.json ? material_json(report) : material_text(title, report));
    if (!a.json && !legend.empty()) fmt::print("\n{}", legend);
    std::optional<Image> swatches;  // rendered once, whatever the number of files
    for (const std::filesystem::path file : a.plots) {
        if (!is_picture(file)) {
            write_text(file, profile_plot(title, medium));
        } else {
            if (!swatches) swatches = render_swatches(columns, file, run.progress, run.stats);
            write_picture(file, *swatches);
        }
        run.progress.note(fmt::format("wrote {}", file.string()));
    }
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    return tool_main(
        "tallow-material",
        "Tells all that follows from a translucent material's coefficients: derived quantities, "
        "and profile and total reflectance under every model. Lengths in mm.",
        argc, argv, [&](CommandLine& line) { declare(line, arguments); },
        [&](ToolRun& run) { describe(arguments, run); });
}
