// SPDX-License-Identifier: Apache-2.0
// tallow-material as users run it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/process.h"
#include "tests/support/test_files.h"

namespace tallow::test {
namespace {

using std::filesystem::path;

Result material(const std::vector<std::string>& arguments) {
    std::filesystem::create_directories(TALLOW_TEST_OUT);  // run() puts its streams there
    return run(TALLOW_MATERIAL, arguments);
}

constexpr const char* kScene = R"(cameras:
  main: {type: perspective, position: [0, 3, 9], look_at: [0, 0, 0], fov_deg: 40, resolution: [8, 8]}
materials:
  tinted: {type: subsurface, diffuse_color: [0.8, 0.5, 0.4], mean_free_path: [1, 0.5, 0.2], eta: 1.4, model: dipole}
  coarse: {type: subsurface, sigma_a: 0.01, sigma_s_prime: 0.4, eta: 1.4, single_scattering: off}
  floor: {type: diffuse, reflectance: 0.5}
)";

bool contains(const std::string& text, const std::string& what) {
    return text.find(what) != std::string::npos;
}

TEST(MaterialCli, PrintsTablesForAPreset) {
    const Result result = material({"marble", "--profile", "0.5,2"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(result.out.starts_with("marble (preset, [JMLH01])\n"));
    EXPECT_TRUE(
        contains(result.out, "mean free path                   0.45618     0.38108     0.33255"));
    EXPECT_TRUE(contains(result.out, "r = 0.5 mm"));
    EXPECT_TRUE(contains(result.out, "r = 2 mm"));
}

TEST(MaterialCli, ReadsMaterialsOfScenes) {
    const path folder = fresh_folder();
    write_bytes(folder / "scene.yaml", kScene);
    const Result result = material({(folder / "scene.yaml").string() + ":tinted"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(
        contains(result.out, "dipole                               0.8         0.5         0.4"));
    EXPECT_TRUE(
        contains(result.out, "mean free path                         1         0.5         0.2"));
}

TEST(MaterialCli, TakesCoefficientsAndPrintsJson) {
    const Result result = material({"--sigma-a", "1e-12,0,3", "--sigma-s-prime", "1,1,1", "--eta",
                                    "1.3", "--profile", "1", "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(result.out.starts_with("{\n"));
    for (const char* key : {"sigma_a", "sigma_s_prime", "g", "eta", "alpha_prime", "sigma_tr",
                            "mean_free_path_mm", "F_dr", "A", "z_r_mm", "z_v_mm", "models"})
        EXPECT_TRUE(contains(result.out, fmt::format("\"{}\": ", key))) << key;
}

TEST(MaterialCli, FlagsChangeAPreset) {
    const Result result = material({"marble", "--eta", "1.3", "--g", "0.5", "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(result.out, "\"eta\": 1.29999"));
    EXPECT_TRUE(contains(result.out, "\"g\": 0.5"));
}

TEST(MaterialCli, WritesPlots) {
    const path folder = fresh_folder();
    const Result result =
        material({"marble", "--plot", folder / "curves.svg", "--stats", folder / "stats.json"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const std::string svg = read_bytes(folder / "curves.svg");
    EXPECT_TRUE(svg.starts_with("<?xml"));
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
    EXPECT_TRUE(contains(read_bytes(folder / "stats.json"), "tallow-material"));
}

TEST(MaterialCli, RendersAnAbsorptionSeries) {
    const path folder = fresh_folder();
    write_bytes(folder / "scene.yaml", kScene);  // `coarse` renders in a second
    const Result result =
        material({(folder / "scene.yaml").string() + ":coarse", "--vary", "sigma_a=0.01..1",
                  "--steps", "2", "--plot", folder / "row.png", "--plot", folder / "row.exr"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(result.out, "swatch 1: sigma_a = 0.01\nswatch 2: sigma_a = 1\n"));
    EXPECT_GT(std::filesystem::file_size(folder / "row.png"), 1000u);
    EXPECT_GT(std::filesystem::file_size(folder / "row.exr"), 1000u);
}

struct Row {
    std::vector<std::string> arguments;
    int exit_code;
    std::string message;
};

TEST(MaterialCli, WrongInput) {
    const path folder = fresh_folder();
    const std::string scene = folder / "scene.yaml", bad = folder / "bad.yaml";
    write_bytes(scene, kScene);
    write_bytes(bad, "cameras: 1\n");
    const std::vector<std::string> given = {"--sigma-a", "1,1,1", "--sigma-s-prime", "1,1,1"};
    const std::vector<Row> rows = {
        {{},
         2,
         "usage: MATERIAL: expected a preset, SCENE:NAME, or --sigma-a, --sigma-s-prime and "
         "--eta"},
        {given, 2,
         "usage: MATERIAL: expected a preset, SCENE:NAME, or --sigma-a, --sigma-s-prime "
         "and --eta"},
        {{scene + ":wax"},
         2,
         fmt::format("usage: MATERIAL: expected one of {}:{{tinted, coarse}}, got 'wax'", scene)},
        {{bad + ":wax"}, 3, fmt::format("error: {}:1:10: cameras: expected a map, got '1'", bad)},
        {{"marble", "--profile", "1,x"},
         2,
         "usage: --profile: expected distances R,... >= 0 in mm, got 'x'"},
        {{"marble", "--sigma-a", "1,2"},
         2,
         "usage: --sigma-a: expected three numbers R,G,B >= 0, got '1,2'"},
        {{"marble", "--sigma-a", "0,0,0", "--sigma-s-prime", "0,1,1"},
         2,
         "usage: --sigma-a: expected sigma_a + sigma_s_prime >= 1e-06 in each channel, got 0"},
        {{"marble", "--eta", "0.9"},
         2,
         "usage: --eta: expected a relative index in [1, 3], got '0.9'"},
        {{"marble", "--plot", "x.gif"},
         2,
         "usage: --plot: expected a name ending in .svg, .png or .exr, got 'x.gif'"},
        {{"marble", "--vary", "eta=1..2"},
         2,
         "usage: --vary: expected a picture to write, --plot FILE.png or FILE.exr"},
        {{"marble", "--vary", "dilution=0.1..1", "--plot", "x.png"},
         2,
         "usage: --vary: dilution: 'marble' is not the preset of a liquid"},
        {{"marble", "--steps", "3"},
         2,
         "usage: --steps: expected a parameter to vary, --vary KEY=A..B"},
    };
    for (const Row& row : rows) {
        const Result result = material(row.arguments);
        EXPECT_EQ(result.exit_code, row.exit_code) << row.message;
        EXPECT_EQ(result.first_error_line(), fmt::format("tallow-material: {}", row.message));
        EXPECT_EQ(result.out, "");
    }
}

TEST(MaterialCli, UnknownPresetListsAllNames) {
    const Result result = material({"granite"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(result.err.starts_with(
        "tallow-material: usage: MATERIAL: expected one of apple, apple-juice, "));
    EXPECT_TRUE(contains(result.err, ", wholemilk, or SCENE:NAME, got 'granite'\n"));
}

TEST(MaterialCli, AFileThatCannotBeWrittenIsAnOutputError) {
    const Result result = material({"marble", "--plot", "/nonexistent/x.svg"});
    EXPECT_EQ(result.exit_code, 4);
    EXPECT_TRUE(
        contains(result.err, "tallow-material: error: /nonexistent/x.svg: cannot be written: "))
        << result.err;
}

}  // namespace
}  // namespace tallow::test
