// SPDX-License-Identifier: Apache-2.0
// The parts of tallow-material: derived quantities, JSON, plot, variation, swatch.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <regex>

#include "common/base/errors.h"
#include "material/find_material.h"
#include "material/material_json.h"
#include "material/material_text.h"
#include "material/profile_plot.h"
#include "material/swatch.h"
#include "material/swatch_scene.h"
#include "material/vary_medium.h"
#include "tests/support/error_text.h"
#include "tests/support/test_files.h"

namespace tallow {
namespace {

const Medium kForward{{0.01f, 0.02f, 0.1f}, {1.5f, 1.0f, 0.5f}, 0.5f, 1.4f};

// The formulas of Medium's and the dipole's doc blocks, by hand.
TEST(DescribeMaterial, DerivesQuantities) {
    const MaterialReport report = describe_material(kForward, {});
    for (std::size_t c = 0; c < 3; ++c) {
        const double a = report.sigma_a[c], s = report.sigma_s_prime[c];
        EXPECT_EQ(report.sigma_s[c], s / 0.5);
        EXPECT_EQ(report.sigma_t[c], s / 0.5 + a);
        EXPECT_EQ(report.sigma_t_prime[c], s + a);
        EXPECT_DOUBLE_EQ(report.alpha_prime[c], s / (s + a));
        EXPECT_DOUBLE_EQ(report.albedo[c], s / 0.5 / (s / 0.5 + a));
        EXPECT_DOUBLE_EQ(report.sigma_tr[c], std::sqrt(3 * a * (s + a)));
        EXPECT_DOUBLE_EQ(report.mean_free_path_mm[c], 1 / (s + a));
        EXPECT_DOUBLE_EQ(report.z_v_mm[c], (1 + 4 * report.A / 3) / (s + a));
    }
    EXPECT_DOUBLE_EQ(report.A, (1 + report.F_dr) / (1 - report.F_dr));
    EXPECT_NEAR(report.F_dr, 0.5292, 2e-3);  // eta 1.4; [JMLH01]'s polynomial gives 0.5293
}

// Every model's printed profile integrates to its printed total: trapezoidal rule in ln r. Measured
// 1 %: profiles that peak at r = 0 lose what lies inside the first radius.
TEST(DescribeMaterial, ProfilesIntegrateToTotals) {
    std::vector<double> radii;
    const double step = 0.02;
    for (double x = std::log(1e-3); x < std::log(1e3); x += step) radii.push_back(std::exp(x));
    const MaterialReport report = describe_material(kForward, radii);
    ASSERT_EQ(report.models.size(), kModels.size());
    for (const ModelReport& model : report.models)
        for (std::size_t c = 0; c < 3; ++c) {
            double sum = 0;
            for (std::size_t i = 0; i < radii.size(); ++i)
                sum += 2 * std::numbers::pi * radii[i] * radii[i] * model.profile[i][c] * step;
            EXPECT_NEAR(sum, model.total_reflectance[c], 0.02 * model.total_reflectance[c])
                << model.name << " channel " << c;
        }
}

TEST(DescribeMaterial, DefaultRadiiSpanMeanFreePaths) {
    const auto radii = default_radii({Rgb(0), Rgb(4), 0, 1.3f});
    EXPECT_EQ(radii.size(), 8u);
    EXPECT_DOUBLE_EQ(radii.front(), 0.025);
    EXPECT_DOUBLE_EQ(radii.back(), 5);
}

TEST(MaterialJson, HasTheKeysThatProgramsRead) {
    const std::vector<double> radii = {0.1, 1};
    const MaterialReport report = describe_material(kForward, radii);
    const auto json = nlohmann::json::parse(material_json(report));
    std::vector<std::string> keys;
    for (const auto& [key, value] : json.items()) keys.push_back(key);
    EXPECT_EQ(keys, (std::vector<std::string>{"A", "F_dr", "alpha_prime", "eta", "g",
                                              "mean_free_path_mm", "models", "sigma_a",
                                              "sigma_s_prime", "sigma_tr", "z_r_mm", "z_v_mm"}));
    EXPECT_EQ(json["models"].size(), kModels.size());
    for (const ModelReport& model : report.models) {
        const auto& entry = json["models"][model.name];
        EXPECT_EQ(entry.size(), 2u);
        EXPECT_EQ(entry["total_reflectance"].get<Triple>(), model.total_reflectance);
        for (std::size_t i = 0; i < radii.size(); ++i) {
            const Triple& R = model.profile[i];
            EXPECT_EQ(entry["profile"][i], nlohmann::json({radii[i], R[0], R[1], R[2]}));
        }
    }
}

// Read back, every number is the same double: none was cut to fewer digits.
TEST(MaterialJson, NumbersKeepAllDigits) {
    const MaterialReport report = describe_material(kForward, {});
    const std::string text = material_json(report);
    const auto json = nlohmann::json::parse(text);
    EXPECT_EQ(json["sigma_tr"].get<Triple>(), report.sigma_tr);
    EXPECT_EQ(json["z_v_mm"].get<Triple>(), report.z_v_mm);
    EXPECT_EQ(json["A"].get<double>(), report.A);
    EXPECT_TRUE(std::regex_search(text, std::regex("\\d\\.\\d{15}")));
}

TEST(MaterialText, LinesUpAndNamesUnits) {
    const std::vector<double> radii = {0.5};
    const std::string text = material_text("clay", describe_material(kForward, radii));
    EXPECT_TRUE(text.starts_with("clay\n\n"));
    EXPECT_NE(text.find("sigma_a                             0.01        0.02         0.1  1/mm"),
              std::string::npos)
        << text;
    for (const auto& [name, model] : kModels)
        EXPECT_NE(text.find(fmt::format("R(r), {}", name)), std::string::npos);
    EXPECT_NE(text.find("r = 0.5 mm"), std::string::npos);
}

std::size_t count_of(const std::string& text, const std::string& what) {
    std::size_t count = 0;
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += what.size())
        ++count;
    return count;
}

// Elements open and close in pairs, quotes are balanced, and the title cannot break out.
TEST(ProfilePlot, IsWellFormed) {
    const std::string svg = profile_plot("a < b & \"c\" > d", kForward);
    std::vector<std::string> open;
    const std::regex tag("<(/?)([a-z?A-Z]+)[^<>]*?(/?)>");
    for (std::sregex_iterator it(svg.begin(), svg.end(), tag), end; it != end; ++it) {
        const std::string name = (*it)[2];
        if (name == "?xml" || (*it)[3].length() > 0) continue;
        if ((*it)[1].length() == 0) {
            open.push_back(name);
        } else {
            ASSERT_FALSE(open.empty());
            EXPECT_EQ(open.back(), name);
            open.pop_back();
        }
    }
    EXPECT_TRUE(open.empty());
    EXPECT_EQ(count_of(svg, "<"), count_of(svg, ">"));
    EXPECT_NE(svg.find("a &lt; b &amp; \"c\" &gt; d"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(ProfilePlot, HasACurveAndALegendOfEachModelInEachPanel) {
    const std::string svg = profile_plot("clay", kForward);
    EXPECT_EQ(count_of(svg, "<polyline"), 3 * kModels.size());
    for (const auto& [name, model] : kModels)
        EXPECT_EQ(count_of(svg, fmt::format(">{}<", name)), 3u) << name;
    EXPECT_EQ(count_of(svg, "distance r in mm"), 3u);
    EXPECT_EQ(count_of(svg, "R(r) in 1/mm"), 1u);
}

// A pure absorber reflects nothing: logarithms of zero must not reach the picture.
TEST(ProfilePlot, DrawsAPureAbsorber) {
    const std::string svg = profile_plot("ink", {Rgb(2), Rgb(0), 0, 1.33f});
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(VaryMedium, StepsInEqualRatiosOrDifferences) {
    const auto log_values = variation_values(parse_variation("sigma_a=0.001..0.1"), 3);
    ASSERT_EQ(log_values.size(), 3u);
    EXPECT_DOUBLE_EQ(log_values[0], 0.001);
    EXPECT_DOUBLE_EQ(log_values[1], 0.01);
    EXPECT_DOUBLE_EQ(log_values[2], 0.1);
    const auto linear = variation_values(parse_variation("g=-0.5..0.5"), 5);
    EXPECT_DOUBLE_EQ(linear[2], 0);
    EXPECT_DOUBLE_EQ(linear[4], 0.5);
    EXPECT_EQ(variation_values(parse_variation("eta=1.2..1.6"), 1), std::vector<double>{1.2});
}

TEST(VaryMedium, ScalesChannelsTogether) {
    const Medium absorbing = vary_medium(kForward, Knob::sigma_a, 0.13);
    EXPECT_NEAR(absorbing.sigma_a.r, 0.03, 1e-7);
    EXPECT_NEAR(absorbing.sigma_a.b, 0.3, 1e-6);
    EXPECT_EQ(absorbing.sigma_s_prime, kForward.sigma_s_prime);
    EXPECT_NEAR(vary_medium(kForward, Knob::sigma_s_prime, 2).sigma_s_prime.r, 3, 1e-6);
    EXPECT_EQ(vary_medium({Rgb(0), Rgb(1), 0, 1.3f}, Knob::sigma_a, 0.5).sigma_a, Rgb(0.5f));
    EXPECT_EQ(vary_medium(kForward, Knob::eta, 1.6).eta, 1.6f);
    EXPECT_EQ(vary_medium(kForward, Knob::g, 0.9).g, 0.9f);
    const Medium thin = vary_medium(kForward, Knob::dilution, 0.5);
    EXPECT_EQ(thin.sigma_a, 0.5f * kForward.sigma_a);
    EXPECT_EQ(thin.sigma_s_prime, 0.5f * kForward.sigma_s_prime);
}

TEST(VaryMedium, RefusesWhatItCannotRead) {
    const auto refusal = [](const std::string& text) {
        return error_text<UsageError>([&] { parse_variation(text); });
    };
    EXPECT_EQ(refusal("sigma_a"), "--vary: expected KEY=A..B, got 'sigma_a'");
    EXPECT_EQ(refusal("sigma_a=0.1"), "--vary: expected KEY=A..B, got 'sigma_a=0.1'");
    EXPECT_EQ(refusal("sigma=1..2"),
              "--vary: expected one of sigma_a, sigma_s_prime, eta, g, dilution, got 'sigma'");
    EXPECT_EQ(refusal("sigma_a=0..2"), "--vary: expected a number of 1/mm >= 1e-6, got '0'");
    EXPECT_EQ(refusal("eta=1..1.5x"), "--vary: expected a relative index in [1, 3], got '1.5x'");
    EXPECT_EQ(refusal("dilution=0.1..2"), "--vary: expected a share in [0.001, 1], got '2'");
}

TEST(FindMaterial, LooksInPresetsAndScenes) {
    EXPECT_EQ(find_material("marble").material.medium.eta, 1.5f);
    EXPECT_FALSE(find_material("marble").dilutable);
    EXPECT_TRUE(find_material("espresso").dilutable);
    EXPECT_EQ(find_material("espresso").origin, "preset, undiluted, [NGD06]");
    const auto file = test_out("scene.yaml");
    write_bytes(file,
                "cameras: {main: {type: perspective, position: [0, 0, 9], look_at: [0, 0, 0], "
                "fov_deg: 40, resolution: [4, 4]}}\n"
                "materials: {clay: {type: subsurface, sigma_a: 0.1, sigma_s_prime: 1, eta: 1.3}, "
                "floor: {type: diffuse, reflectance: 1}}\n");
    const FoundMaterial clay = find_material(file.string() + ":clay");
    EXPECT_EQ(clay.name, "clay");
    EXPECT_EQ(clay.origin, file.string());
    EXPECT_EQ(clay.material.medium.sigma_a, Rgb(0.1f));
    EXPECT_EQ(error_text<UsageError>([&] { find_material(file.string() + ":floor"); }),
              fmt::format("MATERIAL: expected one of {}:{{clay}}, got 'floor'", file.string()));
}

double mean_of(const Image& image, int column) {
    double sum = 0;
    for (const char* name : {"R", "G", "B"})
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < kSwatchWidth; ++x)
                sum += double((*image.find_channel(
                    name))[std::size_t(y * image.width + column * kSwatchWidth + x)]);
    return sum;
}

// A coarse medium without single scattering, so that a column takes a fraction of a second.
TEST(Swatch, ColumnsGetDarkerWithAbsorption) {
    const Medium medium{Rgb(0.01f), Rgb(0.4f), 0, 1.4f};
    std::vector<SubsurfaceMaterial> materials;
    for (const double value : {0.001, 1.0}) {
        SubsurfaceMaterial material;
        material.medium = vary_medium(medium, Knob::sigma_a, value);
        material.single_scattering = Switch::off;
        materials.push_back(material);
    }
    Progress progress(true);
    Stats stats;
    const auto folder = fresh_folder();
    const Image row = render_swatches(materials, folder / "row.png", progress, stats);
    EXPECT_EQ(row.width, 2 * kSwatchWidth);
    EXPECT_EQ(row.height, kSwatchHeight);
    EXPECT_GT(mean_of(row, 1), 0);
    EXPECT_LT(mean_of(row, 1), 0.8 * mean_of(row, 0));  // measured 0.29
    write_picture(folder / "row.png", row);
    EXPECT_GT(std::filesystem::file_size(folder / "row.png"), 1000u);
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        EXPECT_EQ(entry.path().filename(), "row.png") << "the cache must be removed";
}

}  // namespace
}  // namespace tallow
